"""A robot that only shows what it is told, with a topic of every kind; and a station for it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from archo_interfaces.msg import BatteryStatus

from archo_tui.base.clock import Clock
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import LogLevel, NodeInfo, TopicEnd, TopicInfo
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.topics.inspect import MessageIntake, TopicWatch
from archo_tui.robot.topics.rows import (
    FieldKind,
    FieldView,
    TopicRequest,
    TopicView,
    shown_elements,
)
from archo_tui.screen.app import ArchoApp
from archo_tui.station.station import Station
from tests.support.clock import NOW, TIME
from tests.support.waiting import DEADLINE


class StandingClock(Clock):
    """Always NOW, unless moved."""

    def __init__(self) -> None:
        self.passed = 0.0

    def monotonic(self) -> float:
        return NOW + self.passed

    def now(self) -> float:
        return TIME + self.passed

    async def sleep(self, seconds: float) -> None:
        """For ever: on a slow machine a second of real time would be seen in a picture."""
        await asyncio.Event().wait()


MOTOR = NodeInfo(
    publishes=(("/motor_status", "archo_interfaces/msg/MotorStatus"),),
    subscribes=(("/battery_level", "archo_interfaces/msg/BatteryStatus"),),
    serves=(
        ("/emergency_stop", "archo_interfaces/srv/EmergencyStop"),
        ("/release_emergency_stop", "std_srvs/srv/Trigger"),
        ("/reset_encoder", "archo_interfaces/srv/ResetEncoder"),
    ),
    actions=(("/move_to_shelf", "archo_interfaces/action/MoveToShelf"),),
    level=LogLevel("UNSET", "INFO"),
)


class StubRobot:
    """Has every verb; none does anything. Knows what the motor's node has on the graph."""

    def __init__(self, snapshot: Snapshot) -> None:
        self.snapshot, self.file = snapshot, snapshot.file
        self.watching = False
        self.stops = Stops()
        self.publications = SimpleNamespace(active=())
        self._receiver: Any = None
        self.show_topic: Callable[[], None] = lambda: None

    def subscribe(self, receiver: Any) -> None:
        self._receiver = receiver
        receiver(self.snapshot)

    @property
    def listening(self) -> bool:
        """True when somebody has subscribed."""
        return self._receiver is not None

    def put(self, snapshot: Snapshot) -> None:
        """Something new was heard."""
        self.snapshot = snapshot
        self._receiver(snapshot)

    async def end_publications(self) -> str:
        return ""

    async def describe(self, node: str) -> NodeInfo | Outcome:
        return MOTOR if node == "/motor_controller" else Outcome(Code.REFUSED, "not on the graph")

    async def follow_topic(
        self,
        topic: str,
        request: Callable[[], TopicRequest],
        show: Callable[[TopicView], None],
    ) -> None:
        """Show a topic now, and as often as `show_topic` is called."""
        self.show_topic = lambda: show(topic_view(topic, request()))
        self.show_topic()

    def __getattr__(self, verb: str) -> Any:
        async def refuse(*_: Any, **__: Any) -> Outcome:
            return Outcome(Code.REFUSED, f"{verb}: the robot says why not")

        if verb == "note":
            return lambda *_, **__: None

        return refuse


class Willing(StubRobot):
    """Does everything at once, and keeps what it was told."""

    def __init__(self, snapshot: Snapshot, *, watching: bool = False) -> None:
        super().__init__(snapshot)
        self.watching = watching
        self.told: list[str] = []

    def __getattr__(self, verb: str) -> Any:
        async def do(*_: Any, **__: Any) -> Outcome:
            self.told.append(verb)
            return Outcome(Code.DONE, "done")

        return super().__getattr__(verb) if verb in ("note", "wait_for_events") else do


def stub_station(
    robot: Any,
    clock: Clock | None = None,
    hosted: tuple[Hosted, ...] = (),
    *,
    attached: bool = False,
    on_disconnect: str = "cancel",
    file_is_default: bool = False,
) -> Station:
    """A station over a stand-in for the robot; its journal forgets everything."""
    host: Any = SimpleNamespace(states=lambda: hosted, usage=lambda _: None)
    kept = Outcome(Code.DONE, "the last minute is recorded")
    recorder: Any = SimpleNamespace(
        trouble="",
        on_view=lambda *_: None,
        keep=lambda on_disk=lambda _: None: on_disk(kept) or kept,
        kept="",
    )
    journal: Any = SimpleNamespace(write=lambda *_, **__: None, failure="")
    return Station(
        robot,
        host,
        journal,
        recorder,
        clock or StandingClock(),
        engine="embedded",
        namespace="/",
        attached=attached,
        on_disconnect=on_disconnect,
        file_is_default=file_is_default,
    )


def stub_app(
    snapshot: Snapshot,
    clock: Clock | None = None,
    hosted: tuple[Hosted, ...] = (),
    keys: Mapping[str, str] | None = None,
    size: tuple[int, int] = (120, 36),
    in_field: bool = False,
    **options: Any,
) -> ArchoApp:
    """The app over a stub, in a terminal of that size.

    Unless it starts `in_field`, somebody has left the goal's field, and digits lead to panels.
    """
    robot: Any = StubRobot(snapshot)
    with sized(size):
        app = ArchoApp(stub_station(robot, clock, hosted, **options), keys)
    app.main.starts_in_field = in_field
    app.animation_level = "none"
    app.NOTIFICATION_TIMEOUT = DEADLINE  # type: ignore[misc]  # s: a busy machine may look late
    return app


def sized(size: tuple[int, int]) -> AbstractContextManager[object]:
    """What an app that is made therein takes for its terminal's size, before it has a driver."""
    return patch.dict("os.environ", COLUMNS=str(size[0]), LINES=str(size[1]))


TYPE = "archo_interfaces/msg/BatteryStatus"
_END = TopicEnd("/battery_monitor", TYPE, "RELIABLE, VOLATILE")
ENDS = TopicInfo(
    (_END,), (_END._replace(node="/dashboard"), _END._replace(node="/_archo_console_lab_1"))
)
_RANGES = 360


def topic_view(topic: str, request: TopicRequest) -> TopicView:
    """Return a topic after a minute of messages at 2 Hz."""
    intake, charges = MessageIntake(), iter(range(120))

    def decode(_: bytes) -> BatteryStatus:
        number = next(charges)
        charge = 87.5 - number / 20 - (15 if number == 60 else 0)
        return BatteryStatus(
            percentage=charge, voltage=24.5, is_charging=40 <= number < 80, battery_health="good"
        )

    units = {"percentage": "%", "voltage": "V"}  # As a robot file may name them.
    watch = TopicWatch(topic, TYPE, units, intake, decode)
    for number in range(120):
        now = TIME - 60 + number / 2
        intake.add(now, bytes(24))
        watch.update(now, request)
    view = watch.update(TIME, request)
    return view._replace(
        fields=(*view.fields, *_others(request)),
        ends=ENDS,
        with_elements=lambda _, arrays: topic_view(topic, request._replace(open_arrays=arrays)),
    )


def _others(request: TopicRequest) -> list[FieldView]:
    """Return further fields, which the type of the topic does not have."""
    value, array = FieldKind.VALUE, FieldKind.ARRAY
    begin = request.open_arrays.get("ranges")
    rows = [
        FieldView("header", FieldKind.GROUP, "std_msgs/Header"),
        FieldView("header.stamp", value, "builtin_interfaces/Time", TIME - 0.4, is_time=True),
        FieldView("header.frame_id", value, "string", "base_link"),
        FieldView("status", value, "uint8", 4, constant="FULL", least=1, greatest=4),
        FieldView(
            "ranges", array, f"float32[{_RANGES}]", _RANGES, unit="m", least=0.12, greatest=9.8,
            nan=3, is_open=begin is not None,
        ),
    ]  # fmt: skip
    if begin is not None:
        shown = shown_elements(begin, _RANGES)
        rows += [FieldView(f"ranges[{n}]", value, "float32", n / 40) for n in shown]
        rows.append(FieldView("ranges[]", FieldKind.MORE, "", _RANGES))
    return [*rows, FieldView("image", array, "uint8[921600]", first="00 01 02 03 04 05 06 07")]
