"""What no topic says, and topics: each is recorded, and shown in a replay at its position."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from std_msgs.msg import Float32, String, UInt8MultiArray

from archo_tui.base.clock import Clock
from archo_tui.recordings.console import STATE, TOLD, change_key, to_json
from archo_tui.recordings.replay import bag as bag_reader
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.replay.player import Player
from archo_tui.recordings.replay.state import ReplayState
from archo_tui.recordings.replay.station import RecordedTopicFollower
from archo_tui.robot.clients import YOU
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.graph import NodeState, Parameter, Resource
from archo_tui.robot.state.snapshot import Hosted, Latch, Life, OpenStop, Snapshot, StopAnswer
from archo_tui.robot.topics.rows import TopicRequest, TopicView
from archo_tui.robot_file import load
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.station.alarms import Alarm, AlarmState
from archo_tui.station.history import History
from archo_tui.station.view import View
from archo_tui.text.state import motion_word
from tests.replay.bags import START, written
from tests.support import clock
from tests.support.archo import ARCHO, SHELF
from tests.support.quiet import until
from tests.support.states import plain_text

SINCE = 1_700_000_000.0  # Unix minus monotonic time of the recording console.
ANOTHER = GoalKind("dock", "Dock", "dock", "x_interfaces/action/Dock", noun="dock")


def goal(begun: float, **changes: Any) -> Goal:
    """A goal that was sent at that time, and of which every other time is later."""
    return Goal(
        SHELF,
        {"shelf_number": 12},
        Phase.LOST,
        sent=begun,
        time=SINCE + 7.0,
        length=18.0,
        remaining=9.0,
        heard=begun + 1.0,
        started=begun + 2.0,
        ended=begun + 3.0,
        cancel_asked=begun + 4.0,
        lost=begun + 5.0,
        unreadable="nan",
        feedback="x 1",
        message="blocked",
        mine=False,
        number=3,
        length_is_guessed=True,
        result="[1]",
        is_found=True,
        way=((begun + 0.5, 9.5), (begun + 1.0, 9.0)),
        id="0123456789abcdef",
    )._replace(**changes)


def told(since: float) -> dict[str, Any]:
    """A value of each recorded field, none of which is the default; monotonic times as Unix."""
    ended = goal(since + 2.0, kind=ANOTHER, phase=Phase.ABORTED, number=2)
    return {
        "goal": goal(since + 10.0),
        "running": 2,
        "history": (ended,),
        "parameters": (
            Parameter("/n", "p", "double[]", [0.5] * 300, [1.5], "of it", 0.0, 9.0, True),
        ),
        "unreported": {"/m": "has not reported its parameters"},
        "nodes": (NodeState("/n", since + 11.0, 2.0, "inactive"),),
        "offered": frozenset({"battery_level"}),
        "events": (Event(SINCE + 3.0, "WARN", "motor", "hot", "", 2, SINCE + 1.0, 5, code="x"),),
        "charge": ((since + 1.0, 80.0), (since + 2.0, 79.5)),
        "open_stop": OpenStop(since + 12.0, StopAnswer.NONE, "/motor"),
        "latch": Latch.UNCERTAIN,
        "latch_doubt": "its node has left",
        "latch_time": SINCE + 4.0,
        "released": since + 3.0,
        "stop_held_by_nobody": True,
        "stop_not_obeyed": True,
        "still_running_after_stop": ("shelf 12",),
        "namespace": "/hall",
        "faults": {"set_charging": "is another type"},
        "publishers": {"battery_level": ("/a", "/b")},
        "duplicate_nodes": ("/twin",),
        "duplicate_servers": {"move_to_shelf": ("/a", "/b")},
        "has_clock": True,
        "clock_offsets": {"/n": -3.5},
        "other_namespaces": ("/yard",),
        "consoles": ("anna_lab_1",),
        "actions": {"/move_to_shelf": ("archo_interfaces/action/MoveToShelf",)},
        "services": {"/stop": ("std_srvs/srv/Trigger",)},
        "resources": (Resource("topic", "/t", ("x/msg/Y",), ("/n",), ("no reader",)),),
        "message_rates": {"/t": MessageRate(since + 11.0, 0.5, 2)},
    }


def view_of(snapshot: Snapshot, **fields: Any) -> View:
    return View(snapshot, 20.0, 20.0, SINCE + 20.0, "embedded", "/", History(), **fields)


def replayed(view: View, file: RobotFile = ARCHO) -> ReplayState:
    """The state after the first message of a recording of that view."""
    state = ReplayState(file, {STATE: "std_msgs/msg/String"})
    said = to_json(view, SINCE, with_events=True)
    state.apply(SINCE + 20.0, STATE, String(data=said))
    return state


def test_each_field_of_a_snapshot_comes_by_the_state_or_by_messages() -> None:
    """A new field that is in neither needs a value in `told`, to be compared below."""
    assert set(told(0.0)) | TOLD == set(Snapshot._fields)
    default = Snapshot()
    assert [name for name, value in told(0.0).items() if value == getattr(default, name)] == []


def test_each_recorded_field_is_shown_in_a_replay() -> None:
    shown = replayed(view_of(Snapshot(**told(0.0)))).snapshot
    wanted = told(SINCE)
    assert {name: getattr(shown, name) for name in wanted} == wanted


def test_a_field_that_changes_is_recorded_at_once() -> None:
    before = change_key(view_of(Snapshot()))
    at_once = {n: v for n, v in told(0.0).items() if n not in ("events", "charge", "message_rates")}
    for name, value in at_once.items():
        assert change_key(view_of(Snapshot(**{name: value}))) != before, name


def test_what_only_the_station_knows_is_recorded_too() -> None:
    hosted = (Hosted("/n", Life.CRASHED, "ZeroDivisionError", "x", ("/s",), "a.py", SINCE),)
    alarm = Alarm(
        "stopped", "STOPPED", SINCE, AlarmState.SHELVED, SINCE + 1, SINCE + 2, 30.0, "a test"
    )
    queue = (QueuedGoal(SHELF, {"shelf_number": 7}, stop_count=4, requester=YOU, is_first=True),)
    view = view_of(
        Snapshot(), hosted=hosted, alarms=(alarm,), queue=queue, held="a STOP", clients=("shell",)
    )
    state = replayed(view).console
    assert (state.engine, state.held, state.clients) == ("embedded", "a STOP", ("shell",))
    assert state.hosted == hosted
    assert state.alarms == (alarm._replace(shelf_ends=30.0 + SINCE),)
    assert [(goal.kind.id, goal.values) for goal in state.queue] == [
        (SHELF.id, {"shelf_number": 7})
    ]


def test_a_secret_is_not_in_a_recording() -> None:
    secret = Parameter("/n", "password", "string", "1234", "1234", is_secret=True)
    said = to_json(view_of(Snapshot(parameters=(secret,))), SINCE, with_events=True)
    assert "1234" not in said
    assert json.loads(said)["snapshot"]["parameters"][0]["value"] == "***"


LATCHED = """
version: 1
name: Base
motion: {topic: motor_status, types: {archo_interfaces/msg/MotorStatus: {moving: moving}}}
stop: {service: e_stop, release: e_release}
"""


def test_a_robot_that_does_not_report_its_stop_is_stopped_in_a_replay_too(here: Path) -> None:
    (here / "base.yaml").write_text(LATCHED)
    file = load.load(here / "base.yaml")
    topics = {STATE: "std_msgs/msg/String", "/motor_status": "archo_interfaces/msg/MotorStatus"}
    state = ReplayState(file, topics)
    live = Snapshot(file, latch=Latch.HELD, latch_time=SINCE)
    said = to_json(view_of(live), SINCE, with_events=True)
    state.apply(SINCE + 1.0, STATE, String(data=said))
    state.apply(SINCE + 1.1, "/motor_status", MotorStatus(moving=False))
    assert state.snapshot.is_stopped
    assert plain_text(motion_word(state.snapshot, SINCE + 1.2, 80)) == "✗ STOPPED"


@pytest.mark.parametrize(
    ("recorded", "namespace"),
    [
        (["/spare/battery_level", "/battery_level"], "/"),
        (["/a/spare/battery_level", "/a/battery_level", "/a/motor_status"], "/a"),
        (["/a/move_to_shelf/_action/feedback"], "/a"),
        (["/chatter"], "/"),
    ],
)
def test_the_robot_is_in_the_namespace_of_most_of_its_topics(
    recorded: list[str], namespace: str
) -> None:
    state = ReplayState(ARCHO, dict.fromkeys(recorded, "x/msg/Y"))
    assert state.snapshot.namespace == namespace


KIND = """
  - {id: there, title: Go there, noun: shelf, action: move_to_shelf,
     type: archo_interfaces/action/MoveToShelf, form: {shelf_number: {label: Shelf}},
     remaining: {field: distance_remaining}}"""
TWO_KINDS = f"version: 1\nname: Base\ngoals:{KIND}{KIND.replace('there', 'back')}\nstop: none\n"
FEEDBACK = "/move_to_shelf/_action/feedback"


def feedback(number: int, left: float) -> Any:
    """A feedback of the goal with the id 01, 02, ..."""
    message = MoveToShelf.Impl.FeedbackMessage()
    message.goal_id.uuid = [number] * 16
    message.feedback.distance_remaining = left
    return message


def shows(state: ReplayState, running: Goal, at: float) -> None:
    """Apply the state of a console that shows that goal."""
    said = to_json(view_of(Snapshot(goal=running, running=2)), SINCE, with_events=False)
    state.apply(SINCE + at, STATE, String(data=said))


def left(state: ReplayState) -> float | None:
    assert state.snapshot.goal is not None
    return state.snapshot.goal.remaining


@pytest.mark.parametrize(("one", "other"), [(0, 0), (1, 0), (0, 1)])
def test_of_two_goals_on_one_action_each_has_its_own_feedback(
    one: int, other: int, here: Path
) -> None:
    (here / "base.yaml").write_text(TWO_KINDS)
    file = load.load(here / "base.yaml")
    state = ReplayState(file, {FEEDBACK: "", STATE: ""})
    fields = {"shelf_number": 7}
    first = Goal(file.goals[one], fields, Phase.MOVING, 1.0, SINCE, number=1, id="01" * 16)
    second = first._replace(kind=file.goals[other], number=2, id="02" * 16)
    shows(state, first, 1.0)
    state.apply(SINCE + 2.0, FEEDBACK, feedback(1, 6.5))
    state.apply(SINCE + 2.1, FEEDBACK, feedback(2, 3.5))
    assert left(state) == 6.5
    shows(state, second, 2.2)  # Which the console shows once the first has ended.
    assert left(state) == 3.5
    state.apply(SINCE + 2.3, FEEDBACK, feedback(1, 6.0))
    state.apply(SINCE + 2.4, FEEDBACK, feedback(2, 3.0))
    assert left(state) == 3.0
    before = state.checkpoint()
    shows(state, first, 2.5)
    assert left(state) == 6.0
    state.restore(before)
    shows(state, first, 2.5)
    assert left(state) == 6.0


REQUEST = TopicRequest(plotted=("data",), plot_columns=10)


def value(views: list[TopicView]) -> float:
    """The value in the newest view."""
    found: Any = views[-1].fields[0].value if views and views[-1].fields else -1.0
    return float(found)


@asynccontextmanager
async def following(
    path: Path, topic: str = "/count"
) -> AsyncIterator[tuple[Player, list[TopicView]]]:
    """A player of a bag, and the views of a topic so far."""
    time = clock.current or Clock()
    player, views = Player(BagFile(path), ARCHO, time), list[TopicView]()
    await until(lambda: player.is_complete)
    follower = RecordedTopicFollower(player, time, topic, lambda: REQUEST, views.append)
    task = asyncio.ensure_future(follower.run())
    try:
        yield player, views
    finally:
        task.cancel()


async def test_the_fields_are_those_at_the_position_also_while_it_plays(tmp_path: Path) -> None:
    sent = [("/count", Float32(data=float(number))) for number in range(1_000)]
    counts = written(tmp_path / "counts.mcap", sent)  # tenths of a second
    async with following(counts) as (player, views):
        for seconds, shown in ((0.05, 0.0), (90.05, 900.0), (30.05, 300.0), (30.25, 302.0)):
            player.go_to(START + seconds)
            await until(lambda shown=shown: value(views) == shown)  # type: ignore[misc]
        field = views[-1].fields[0]
        assert (field.least, field.greatest) == (0.0, 302.0)
        assert views[-1].rate == pytest.approx(10, rel=0.01)
        assert views[-1].age == pytest.approx(0.05, abs=0.01)
        assert views[-1].plots["data"][-1] is not None
        player.go_to(START + 10)
        player.play(on=True)
        del views[:]
        await until(lambda: value(views) > 150.0)
        assert len(views) > 10
    async with following(counts, "/other") as (_, views):
        await until(lambda: views)
        assert views[-1].fault == "it was not recorded"


async def test_of_too_many_bytes_those_around_the_position_are_read_and_open_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bag_reader, "MAX_BYTES", 20_000)
    sent = [("/image", UInt8MultiArray(data=bytes([number] * 1_000))) for number in range(200)]
    path = written(tmp_path / "images.mcap", sent)
    async with following(path, "/image") as (player, views):
        player.go_to(START + 15.05)
        await until(lambda: views and views[-1].fields)
        view = views[-1]
        row = next(row for row in view.fields if row.path == "data")
        assert row.first.startswith("96 96 ")
        assert view.with_elements is not None
        opened = view.with_elements(view, {"data": 700}).fields
        paths = [field.path for field in opened]
        assert next(path for path in paths if "data[" in path) == "data[700]"
        assert opened[paths.index("data[719]")].value == 0x96
