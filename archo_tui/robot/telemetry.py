"""The robot's readings, as their publishers send them. ROS thread only."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from rclpy.qos import QoSProfile

from archo_tui.base.clock import Clock
from archo_tui.base.errors import in_one_line
from archo_tui.base.safe_text import harmless
from archo_tui.robot.graph.endpoints import fitting_qos, is_latched
from archo_tui.robot.messages.period import LEAST_SILENCE, Period
from archo_tui.robot.messages.types import field_paths, load_class
from archo_tui.robot.messages.values import Fields, as_received, flag, integer, number, read, yaw
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.state.graph import node_of
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
from archo_tui.robot_file import check
from archo_tui.robot_file.model import DIAGNOSTICS, Gauge, RobotFile, fields_of

_SAMPLE_PERIOD = 1.0  # Seconds between two samples of the charge that are kept.
_SAMPLES = 300
_JUMP = 0.5  # Percent in the wrong direction that are more than noise.
_MOST_VOLTS, _MOST_SPEED = 1e4, 1e4  # V and m/s; a larger value is no reading.
_FARTHEST = 1e7  # m; more than around a quarter of the earth is no position.
_MOST = 1e15  # Of a gauge without a range: a double has so many digits.


class Reader(NamedTuple):
    """A reading and its topic."""

    # "battery", "motion", "pose", "diagnostics", the index of a gauge, or a topic to be recorded.
    key: object
    topic: str  # The topic as the robot file names it.
    # The fields to read, by message type and name of the value; None: of any type, to be recorded.
    types: Mapping[str, Mapping[str, Fields]] | None
    # Called with a message and the fields of its type; returns True if a value has changed.
    callback: Callable[[Any, Mapping[str, Fields]], bool]


class _Subscription(NamedTuple):
    qos: QoSProfile
    subscription: Any = None  # rclpy's object; None if rclpy made none.
    fault: str = ""  # Why rclpy made none; "" if it did.


class Telemetry:
    """The last readings of battery, motion, pose, gauges and diagnostics."""

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
        self._node, self._robot, self._clock = node, robot, clock
        self._on_reading, self._on_stamp, self._warn = on_reading, on_stamp, warn
        recorded = (Reader(topic, topic, None, lambda *_: False) for topic in record)
        self._readers = (*self._make_readers(), *recorded)
        # By the full name of the topic, and its type.
        self._subscriptions: dict[tuple[str, str], _Subscription] = {}
        self._wanted: dict[tuple[str, str], list[Reader]] = {}
        # Why a topic or one of its publishers is not read, by the topic in the robot file.
        self.faults: dict[str, str] = {}
        # The nodes that publish each reading, by key, and the ids of their publishers: a node that
        # is restarted has new ones.
        self._publishers: dict[object, frozenset[str]] = {}
        self._endpoints: dict[object, frozenset[bytes]] = {}
        # The silence in seconds that is allowed without a period, by key; None for any.
        self._graces: dict[object, float | None] = {}
        self.periods: dict[object, Period] = {}  # The measured ones, by the key of the reading.
        topics = {"battery": robot.battery, "motion": robot.motion, "pose": robot.pose}
        # Those of the robot file, in seconds.
        self._fixed: dict[object, float | None] = {
            key: topic.period for key, topic in topics.items() if topic is not None
        }
        self.battery, self.motion, self.pose = Battery(), Motion(), Pose()
        self.diagnostics = Diagnostics()
        # In the order of the robot file.
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

    def resubscribe(self) -> None:
        """Subscribe to what is published now, and update the faults and the silences allowed."""
        before = dict(self._endpoints)
        self._subscribe_all()
        for key, period in self.periods.items():
            if self._endpoints.get(key) != before.get(key):
                self.periods[key] = period.without_pauses()
        self._change_all(lambda key: {"grace": self._grace(key)})

    def _change_all(self, changes: Callable[[object], dict[str, Any]]) -> None:
        for key in ("battery", "motion", "pose", *range(len(self.gauges))):
            self._put(key, self._reading(key)._replace(**changes(key)))

    def _reading(self, key: Any) -> Any:
        return self.gauges[key] if isinstance(key, int) else getattr(self, key)

    def _put(self, key: Any, reading: Any) -> None:
        if isinstance(key, int):
            self.gauges = (*self.gauges[:key], reading, *self.gauges[key + 1 :])
        else:
            setattr(self, key, reading)

    def _make_readers(self) -> Iterator[Reader]:
        """Yield a reader for each reading that the robot file names."""
        robot = self._robot
        named = (("battery", robot.battery), ("motion", robot.motion), ("pose", robot.pose))
        for key, topic in named:
            if topic is not None:
                types = {kind: _named_fields(fields) for kind, fields in topic.types.items()}
                callback = partial(self._on_message, key, topic.topic, "percentage")
                yield Reader(key, topic.topic, types, callback)
        for place, gauge in enumerate(robot.gauges):
            types = {gauge.type: {"value": gauge.field}}
            callback = partial(self._on_message, place, gauge.topic, gauge.title)
            yield Reader(place, gauge.topic, types, callback)
        if robot.diagnostics:
            types = {DIAGNOSTICS: {}}
            yield Reader("diagnostics", robot.diagnostics, types, self._on_diagnostics)

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
            is_its = node in self._publishers.get(key, ())
            self.periods[key] = period.measured_again(old if is_its else None, new)
        self._change_all(lambda key: {"period": self._period(key)})

    # One subscription for each topic and type: with two, each message would count twice.

    def _subscribe_all(self) -> None:
        faults: dict[str, str] = {}
        wanted: dict[tuple[str, str], list[Reader]] = {}  # By full topic and type.
        published: dict[str, Sequence[Any]] = {}  # The publishers by full topic.
        for reader in self._readers:
            topic = self._node.resolve_topic_name(reader.topic)
            if topic not in published:
                published[topic] = self._node.get_publishers_info_by_topic(topic)
            if (kind := self._usable(reader, published[topic], faults)) is not None:
                wanted.setdefault((topic, kind), []).append(reader)
        for key in [key for key in self._subscriptions if key not in wanted]:
            # A topic without publishers keeps its subscription: they may come back.
            if published[key[0]]:
                self._end(self._subscriptions.pop(key))
        self._wanted |= wanted
        for key, readers in wanted.items():
            self._subscribe(key, published[key[0]])
            if self._subscriptions[key].fault:
                faults.setdefault(readers[0].topic, self._subscriptions[key].fault)
        for topic, fault in faults.items():
            if self.faults.get(topic) != fault:
                is_read = any(r.topic == topic and r.types is not None for r in self._readers)
                self._warn(fault if is_read else f"not recorded: {fault}")
        self.faults = faults

    def _usable(
        self, reader: Reader, publishers: Sequence[Any], faults: dict[str, str]
    ) -> str | None:
        """Return the first published type that a reader can read; None if there is none."""
        self._publishers[reader.key] = frozenset(map(node_of, publishers))
        self._endpoints[reader.key] = frozenset(bytes(info.endpoint_gid) for info in publishers)
        if not publishers:
            self._graces[reader.key] = LEAST_SILENCE  # Nobody is left to send more.
            return None
        kinds: list[str] = sorted({info.topic_type for info in publishers})
        types = {kinds[0]: {}} if reader.types is None else reader.types
        known = {kind: load_class(kind) for kind in kinds if kind in types}
        lacking = {k: _lacking(reader.topic, k, known[k], types[k]) for k in known}
        usable = [kind for kind in known if not lacking[kind]]
        fault = next(filter(None, lacking.values()), "")
        fault = fault or check.unexpected_type(reader.topic, kinds, types)
        if fault:
            faults.setdefault(reader.topic, fault)
        if not usable:
            return None
        # A latched message may be sent once, and holds as long as its publisher is there.
        if is_latched(publishers):
            self._graces[reader.key] = None
        else:
            self._graces.pop(reader.key, None)
        return usable[0]

    def _subscribe(self, key: tuple[str, str], publishers: Sequence[Any]) -> None:
        """Subscribe with a QoS that fits, unless that is done."""
        (topic, kind), qos, old = key, fitting_qos(publishers), self._subscriptions.get(key)
        if old is not None and old.qos == qos:
            return
        if old is not None:
            self._end(old)
        callback = partial(self._on_topic, key)
        try:
            made = self._node.listen_quietly(load_class(kind), topic, callback, qos)
            self._subscriptions[key] = _Subscription(qos, made)
        except Exception as error:  # Fast DDS allows one type of a topic in a process.
            name = self._wanted[key][0].topic
            fault = check.not_subscribed(name, kind, in_one_line(error))
            self._subscriptions[key] = _Subscription(qos, None, fault)

    def _on_topic(self, key: tuple[str, str], message: Any) -> None:
        topic, kind = key
        header = getattr(message, "header", None)
        if header is not None and hasattr(header, "stamp"):
            self._on_stamp(topic, header.stamp)
        changed: dict[str, bool] = {}  # By the topic's name in the robot file.
        for reader in self._wanted[key]:
            new = reader.callback(message, {} if reader.types is None else reader.types[kind])
            changed[reader.topic] = changed.get(reader.topic, False) or new
        for name, has_changed in changed.items():
            self._on_reading(name, has_changed)

    def _end(self, ended: _Subscription) -> None:
        if ended.subscription is not None:
            self._node.destroy_subscription(ended.subscription)

    def _on_message(
        self, key: object, topic: str, title: str, message: Any, fields: Mapping[str, Fields]
    ) -> bool:
        """Take a message of a reading; return True if a value has changed."""
        found = {name: read(field, message) for name, field in fields.items()}
        now, last = self._clock.monotonic(), self._reading(key)
        self.periods[key] = self.periods.get(key, Period()).with_message_at(now)
        new = last._replace(
            **(_PARSERS[key](found) if isinstance(key, str) else _gauge(last.gauge, found)),
            received=now,
            period=self._period(key),
            grace=self._grace(key),
        )
        self._put(key, new)
        if isinstance(new, (Battery, GaugeReading)) and new.unreadable and not last.unreadable:
            allowed = "within 0 .. 100" if key == "battery" else _range_text(last.gauge)
            self._warn(f"{topic}: {title} {new.unreadable} is not {allowed}")
        if isinstance(new, Battery):
            self._sample(now, turned=new.charging != last.charging)
        return bool(new != last._replace(received=now))

    def _on_diagnostics(self, message: Any, _fields: Mapping[str, Fields]) -> bool:
        self.diagnostics.add(message, self._clock.monotonic())
        return True

    def _period(self, key: object) -> float | None:
        measured = self.periods.get(key)
        return self._fixed.get(key) or (None if measured is None else measured.typical)

    def _grace(self, key: object) -> float | None:
        """Return the seconds of silence allowed while a period is not known; None for any."""
        if key in self._graces:
            return self._graces[key]
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


def _battery(found: Mapping[str, Any]) -> dict[str, Any]:
    percentage = number(found.get("percentage"), 0.0, 100.0)
    return {
        "percentage": percentage,
        "unreadable": "" if percentage is not None else as_received(found.get("percentage")),
        "voltage": number(found.get("voltage"), 0.0, _MOST_VOLTS),
        "charging": flag(found.get("charging")),
        "discharging": flag(found.get("discharging")),
        "health": harmless(str(found.get("health") or "")) or None,
    }


def _motion(found: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "count": integer(found.get("count")),
        "speed": number(found.get("speed"), -_MOST_SPEED, _MOST_SPEED),
        "moving": flag(found.get("moving")),
        "stopped": flag(found.get("stopped")),
    }


def _pose(found: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "x": number(found.get("x"), -_FARTHEST, _FARTHEST),
        "y": number(found.get("y"), -_FARTHEST, _FARTHEST),
        "yaw": yaw(found.get("orientation")),
        "frame": harmless(str(found.get("frame") or "")),
    }


def _gauge(gauge: Gauge, found: Mapping[str, Any]) -> dict[str, Any]:
    low = -_MOST if gauge.low is None else gauge.low
    value = number(found["value"], low, _MOST if gauge.high is None else gauge.high)
    return {"value": value, "unreadable": "" if value is not None else as_received(found["value"])}


_PARSERS = {"battery": _battery, "motion": _motion, "pose": _pose}


def _named_fields(fields: Any) -> dict[str, Fields]:
    """Return the fields that the robot file names, by reading; it may leave some out."""
    return {name: field for name, field in vars(fields).items() if field is not None}


def _range_text(gauge: Gauge) -> str:
    limited = gauge.low is not None and gauge.high is not None
    return f"within {gauge.low:g} .. {gauge.high:g}" if limited else "a number of this gauge"


def _lacking(topic: str, kind: str, message_class: Any, fields: Mapping[str, Fields]) -> str:
    """Return why a type cannot be read: not installed, or without a field of the readers; or ""."""
    if message_class is None:
        return check.not_installed(topic, kind)
    named = [field for given in fields.values() for field in fields_of(given)]
    wanted = [(field.where, field.field) for field in named]
    return check.unknown_field(kind, wanted, field_paths(message_class))


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
        """Update the table with the statuses of a DiagnosticArray."""
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


# The clocks of other computers.

LARGEST = 1.0  # Seconds; a larger offset is reported.
_COMPARED = 3  # Stamps; the one that fits best counts, since a message may be late.


class ClockOffsets:
    """The offset between the clock of each source of stamps, a node or a topic, and this one's."""

    def __init__(self) -> None:
        # The offsets larger than LARGEST, by source: its clock minus ours, in seconds.
        self.large: Mapping[str, float] = {}
        self._offsets: dict[str, deque[float]] = {}

    def add(self, source: str, stamp: Any, now: float) -> bool:
        """Compare the best of three stamps with its receipt; return True if `large` changes."""
        if not (stamp.sec or stamp.nanosec):
            return False
        offsets = self._offsets.setdefault(source, deque(maxlen=_COMPARED))
        offsets.append(stamp.sec + stamp.nanosec * 1e-9 - now)
        offset = min(offsets, key=abs)
        known = self.large.get(source)
        if len(offsets) < _COMPARED or abs(offset) <= LARGEST:
            if known is not None:
                self.large = {name: o for name, o in self.large.items() if name != source}
            return known is not None
        if known is not None and abs(known - offset) < 1.0:
            return False
        self.large = {**self.large, source: offset}
        return True

    def forget(self, sources: Collection[str]) -> None:
        """Remove sources from `large`, and forget their stamps; unknown sources are ignored."""
        self.large = {name: offset for name, offset in self.large.items() if name not in sources}
        for source in sources:
            self._offsets.pop(source, None)
