"""The readings of battery, motion and gauges, as their publishers send them. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from archo_tui.clock import Clock
from archo_tui.robot.messages.period import Period
from archo_tui.robot.messages.values import Fields, as_received, flag, integer, number, read, yaw
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.readings.subscriptions import Reader, ReadingSubscriptions
from archo_tui.robot.state.readings import (
    WORST_FIRST,
    Battery,
    Diagnostic,
    DiagnosticLevel,
    GaugeReading,
    Motion,
    Pose,
)
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.known_types import DIAGNOSTICS
from archo_tui.robot_file.model import Gauge, RobotFile
from archo_tui.safe_text import harmless

_SAMPLE_PERIOD = 1.0  # Seconds between two samples of the charge that are kept.
_SAMPLES = 300
_JUMP = 0.5  # Percent in the wrong direction that are more than noise.
_MOST_VOLTS, _MOST_SPEED = 1e4, 1e4  # V and m/s; a larger value is no reading.
_FARTHEST = 1e7  # m; more than around a quarter of the earth is no position.
_MOST = 1e15  # Of a gauge without a range: a double has so many digits.


class Telemetry:
    """The last readings of battery, motion, pose, gauges and diagnostics. ROS thread only.

    They are read from the topics and fields that the robot file names.
    """

    def __init__(
        self,
        node: ConsoleNode,
        robot: RobotFile,
        clock: Clock,
        on_reading: Callable[[str, bool], None],
        warn: Callable[[str], None],
        on_stamp: Callable[[str, Any], None] = lambda *_: None,
        record: Sequence[str] = (),  # Further topics, which only the black box has.
    ) -> None:
        self._robot, self._clock = robot, clock
        self._warn = warn
        readers = [*self._make_readers()]
        readers += [Reader(topic, topic, None, lambda *_: False) for topic in record]
        self._subscriptions = ReadingSubscriptions(node, readers, on_reading, on_stamp, warn)
        self.periods: dict[object, Period] = {}  # The measured ones, by the key of the reading.
        topics = {"battery": robot.battery, "motion": robot.motion, "pose": robot.pose}
        # Those of the robot file, in seconds.
        self._fixed: dict[object, float | None] = {
            key: topic.period for key, topic in topics.items() if topic is not None
        }
        self.battery = Battery()
        self.motion = Motion()
        self.pose = Pose()
        self.diagnostics = Diagnostics()  # The last diagnostic status of each part.
        # The last readings of the gauges, in the order of the robot file.
        self.gauges = tuple(GaugeReading(gauge) for gauge in robot.gauges)
        # Samples of the charge, the oldest first: monotonic seconds and percent.
        self.charge: tuple[tuple[float, float], ...] = ()

    def in_snapshot(self, snapshot: Snapshot) -> Snapshot:
        """Return a snapshot with these readings in place of its own."""
        return snapshot._replace(
            battery=self.battery,
            motion=self.motion,
            pose=self.pose,
            gauges=self.gauges,
            diagnostics=self.diagnostics.all,
            charge=self.charge,
        )

    @property
    def faults(self) -> Mapping[str, str]:
        """The reasons why a topic or one of its publishers is not read, by its name in the file."""
        return self._subscriptions.faults

    def resubscribe(self) -> None:
        """Subscribe to what is published now, and update the faults and the silences allowed."""
        before = dict(self._subscriptions.endpoints)
        self._subscriptions.update()
        for key, period in self.periods.items():
            if self._subscriptions.endpoints.get(key) != before.get(key):
                self.periods[key] = period.without_pauses()
        self._change_all(lambda key: {"grace": self._grace(key)})

    def _change_all(self, changes: Callable[[object], dict[str, Any]]) -> None:
        self.battery = self.battery._replace(**changes("battery"))
        self.motion = replace(self.motion, **changes("motion"))
        self.pose = self.pose._replace(**changes("pose"))
        self.gauges = tuple(
            reading._replace(**changes(place)) for place, reading in enumerate(self.gauges)
        )

    def _make_readers(self) -> Iterator[Reader]:
        """Yield a reader for each reading that the robot file names."""
        for key, topic_of, callback in (
            ("battery", self._robot.battery, self._on_battery),
            ("motion", self._robot.motion, self._on_motion),
            ("pose", self._robot.pose, self._on_pose),
        ):
            if topic_of is not None:
                types = {kind: _named_fields(fields) for kind, fields in topic_of.types.items()}
                yield Reader(key, topic_of.topic, types, callback)
        if topic := self._robot.diagnostics:
            yield Reader("diagnostics", topic, {DIAGNOSTICS: {}}, self._on_diagnostics)
        for place, gauge in enumerate(self._robot.gauges):
            types = {gauge.type: {"value": gauge.field}}
            yield Reader(place, gauge.topic, types, partial(self._on_gauge, place))

    def is_robot_heard(self) -> bool:
        """Return True while battery or motion messages come, or if the robot file has neither."""
        if self._robot.battery is None and self._robot.motion is None:
            return True
        now, last = self._clock.monotonic(), (self.battery, self.motion)
        return any(reading.received is not None and not reading.is_old(now) for reading in last)

    def forget_periods(self, node: str, old: object, new: object) -> None:
        """Measure every period again, since a parameter has changed that may set one of them.

        Until then silence is judged by the periods known so far. If the parameter seems to be the
        period of a topic that its node publishes, the new value holds at once if it is longer.
        """
        for key, period in self.periods.items():
            is_its = node in self._subscriptions.publishers.get(key, ())
            self.periods[key] = period.measured_again(old if is_its else None, new)
        self._change_all(lambda key: {"period": self._period(key)})

    def _on_battery(self, message: Any, fields: Mapping[str, Fields]) -> bool:
        assert self._robot.battery is not None
        topic = self._robot.battery.topic
        found = {name: read(field, message) for name, field in fields.items()}
        now, charging = self._clock.monotonic(), self.battery.charging
        percentage, before = found.get("percentage"), self.battery.unreadable
        reading = number(percentage, 0.0, 100.0)
        unreadable = "" if reading is not None else as_received(percentage)
        if unreadable and not before:
            self._warn(f"{topic}: percentage {unreadable} is not within 0 .. 100")
        last = self.battery
        self.battery = Battery(
            percentage=reading,
            voltage=number(found.get("voltage"), 0.0, _MOST_VOLTS),
            charging=flag(found.get("charging")),
            discharging=flag(found.get("discharging")),
            health=harmless(str(found.get("health") or "")) or None,
            unreadable=unreadable,
            **self._received("battery", now),
        )
        self._sample(now, turned=charging != self.battery.charging)
        return _differs(last, self.battery)

    def _on_motion(self, message: Any, fields: Mapping[str, Fields]) -> bool:
        assert self._robot.motion is not None
        found = {name: read(field, message) for name, field in fields.items()}
        now, last = self._clock.monotonic(), self.motion
        self.motion = Motion(
            count=integer(found.get("count")),
            speed=number(found.get("speed"), -_MOST_SPEED, _MOST_SPEED),
            moving=flag(found.get("moving")),
            stopped=flag(found.get("stopped")),
            **self._received("motion", now),
        )
        return _differs(last, self.motion)

    def _on_pose(self, message: Any, fields: Mapping[str, Fields]) -> bool:
        found = {name: read(field, message) for name, field in fields.items()}
        now, last = self._clock.monotonic(), self.pose
        self.pose = Pose(
            x=number(found.get("x"), -_FARTHEST, _FARTHEST),
            y=number(found.get("y"), -_FARTHEST, _FARTHEST),
            yaw=yaw(found.get("orientation")),
            frame=harmless(str(found.get("frame") or "")),
            **self._received("pose", now),
        )
        return _differs(last, self.pose)

    def _on_diagnostics(self, message: Any, _fields: Mapping[str, Fields]) -> bool:
        self.diagnostics.add(message, self._clock.monotonic())
        return True

    def _on_gauge(self, place: int, message: Any, fields: Mapping[str, Fields]) -> bool:
        gauge, last, now = self._robot.gauges[place], self.gauges[place], self._clock.monotonic()
        value = read(fields["value"], message)
        reading = number(value, *_range(gauge))
        unreadable = "" if reading is not None else as_received(value)
        if unreadable and not last.unreadable:
            self._warn(f"{gauge.topic}: {gauge.title} {unreadable} is not {_range_text(gauge)}")
        timed = self._received(place, now)
        new = GaugeReading(gauge, reading, unreadable=unreadable, **timed)
        self.gauges = (*self.gauges[:place], new, *self.gauges[place + 1 :])
        return _differs(last, new)

    def _received(self, key: object, now: float) -> dict[str, Any]:
        """Count a message of a reading; return the fields that tell when it came."""
        self.periods[key] = self.periods.get(key, Period()).with_message_at(now)
        return {"received": now, "period": self._period(key), "grace": self._grace(key)}

    def _period(self, key: object) -> float | None:
        measured = self.periods.get(key)
        return self._fixed.get(key) or (None if measured is None else measured.typical)

    def _grace(self, key: object) -> float | None:
        """Return the seconds of silence allowed while a period is not known; None for any."""
        if key in self._subscriptions.graces:
            return self._subscriptions.graces[key]
        return self.periods.get(key, Period()).grace

    def _sample(self, now: float, *, turned: bool) -> None:
        """Add the present charge to `charge`, unless the last sample is less than a second old."""
        percentage, kept = self.battery.percentage, self.charge
        if percentage is not None and kept:  # The battery was changed, or its node restarted.
            rise = percentage - kept[-1][1]
            turned = turned or (-rise if self.battery.charging else rise) > _JUMP
        kept = () if turned else kept
        if percentage is not None and (not kept or now - kept[-1][0] >= _SAMPLE_PERIOD):
            self.charge = (*kept[-_SAMPLES + 1 :], (now, percentage))


def _differs(last: Any, new: Any) -> bool:
    """Return True if two readings differ in more than when they came."""
    values, before = (vars(r) if isinstance(r, Motion) else r._asdict() for r in (new, last))
    return any(value != before[name] for name, value in values.items() if name != "received")


def _named_fields(fields: Any) -> dict[str, Fields]:
    """Return the fields that the robot file names, by reading; it may leave some out."""
    return {name: field for name, field in vars(fields).items() if field is not None}


def _range(gauge: Gauge) -> tuple[float, float]:
    low = -_MOST if gauge.low is None else gauge.low
    return low, _MOST if gauge.high is None else gauge.high


def _range_text(gauge: Gauge) -> str:
    limited = gauge.low is not None and gauge.high is not None
    return f"within {gauge.low:g} .. {gauge.high:g}" if limited else "a number of this gauge"


# Diagnostics.

_MOST_PARTS = 1000  # Parts that are kept; a publisher of ever new names must not fill the memory.
# The constants of diagnostic_msgs/msg/DiagnosticStatus.
_LEVELS = dict(enumerate(DiagnosticLevel))


_Key = tuple[str, str]  # The name and the hardware id of a part.


class Diagnostics:
    """The last diagnostic status of each part of the robot, by its name and hardware id."""

    def __init__(self) -> None:
        self.all: tuple[Diagnostic, ...] = ()  # The statuses, sorted by name and hardware id.
        self._by_key: Mapping[_Key, Diagnostic] = {}
        self._periods: dict[_Key, Period] = {}

    def add(self, message: Any, now: float) -> None:
        """Update the table with the statuses of a DiagnosticArray.

        Of several statuses of one part in the array, the worst counts.
        """
        found = dict(self._by_key)
        for status in _worst(message.status, now):
            period = self._periods.get(status.key, Period()).with_message_at(now)
            self._periods[status.key] = period
            found[status.key] = status._replace(period=period.typical)
            unnamed = found.get((status.name, ""))
            if status.hardware_id and unnamed and unnamed.level is DiagnosticLevel.OK:
                del found[unnamed.key]
        if len(found) > _MOST_PARTS:  # What is OK, and was received longest ago, makes way.
            kept = sorted(
                found.values(), key=lambda s: (s.level is DiagnosticLevel.OK, -s.received)
            )
            found = {status.key: status for status in kept[:_MOST_PARTS]}
        self._periods = {key: self._periods[key] for key in found}
        self._replace_by(found)

    def forget(self, key: tuple[str, str]) -> None:
        """Drop the part of a name and hardware id."""
        self._periods.pop(key, None)
        self._replace_by({k: status for k, status in self._by_key.items() if k != key})

    def _replace_by(self, found: Mapping[_Key, Diagnostic]) -> None:
        self._by_key = found
        self.all = tuple(found[key] for key in sorted(found))


def _worst(statuses: Iterable[Any], now: float) -> Iterable[Diagnostic]:
    """Return the worst status of each part in one array; of equally bad ones, the first."""
    worst: dict[_Key, Diagnostic] = {}
    for status in statuses:
        name = harmless(status.name) or "(without a name)"
        level = _LEVELS.get(_level_number(status.level), DiagnosticLevel.ERROR)
        text = harmless(status.message)
        new = Diagnostic(name, harmless(status.hardware_id), level, text, now)
        known = worst.setdefault(new.key, new)
        if WORST_FIRST.index(level) < WORST_FIRST.index(known.level):
            worst[new.key] = new
    return worst.values()


def _level_number(level: Any) -> int:
    """Return a level as a number; rosidl's Python has a `byte` as `bytes` of length one."""
    return level[0] if isinstance(level, bytes) else int(level)
