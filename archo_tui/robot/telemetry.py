"""Hears battery and motor, with the type and QoS that the publishers have. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from enum import Enum, auto
from functools import partial
from operator import attrgetter
from typing import Any, NamedTuple

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from archo_tui.clock import Clock
from archo_tui.robot import message_classes, messages
from archo_tui.robot.listener import Listener
from archo_tui.robot.period import LEAST_SILENCE, UNMEASURED, Period
from archo_tui.robot.readings import Fields, as_received, flag, integer, number, read
from archo_tui.robot.state import Battery, Motion, Reading, in_namespace
from archo_tui.robot.text import harmless
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import Gauge, RobotFile, fields_of

_DEPTH = 10
_SAMPLE_PERIOD = 1.0  # s between two samples of the charge that are kept
_SAMPLES = 300
_JUMP = 0.5  # % in the wrong direction that is more than noise
_MOST_VOLTS, _MOST_SPEED = 1e4, 1e4  # V, m/s; beyond that it is not a reading
_MOST = 1e15  # of a gauge without a range: so many digits a double has

_BATTERY = (
    attrgetter("charging", "discharging", "health", "period", "unreadable"),
    attrgetter("percentage", "voltage"),
)
_MOTION = attrgetter("moving", "stopped", "period"), attrgetter("count", "speed")
_GAUGE = attrgetter("period", "unreadable"), attrgetter("value")


class News(Enum):
    """What a message says that the one before did not."""

    NONE = auto()  # nothing but its time
    NUMBERS = auto()  # readings went on, as they do all the time
    WORDS = auto()  # what a person acts on: that it is stopped, or cannot be read


# Where several readings come from one message, the weightiest news of them is passed on.
_WEIGHT = attrgetter("value")


class _Reader(NamedTuple):
    """What takes a reading from a topic."""

    key: object  # "battery", "motion", or the place of a gauge
    topic: str  # as in the robot file
    types: Mapping[str, Mapping[str, Fields]]  # the fields to read, by message type
    callback: Callable[[Any, Mapping[str, Fields]], News]


class _Subscription(NamedTuple):
    """One topic that is listened to."""

    qos: tuple[bool, bool]  # reliable, latched
    keys: tuple[object, ...]  # of its readers
    subscription: Any = None


Kept = tuple[
    Battery,
    Motion,
    tuple[Reading, ...],
    tuple[tuple[float, float], ...],
    Mapping[object, Period],
]


class Telemetry:
    """The last readings of battery, motion and gauges, as the robot's file says."""

    def __init__(
        self,
        node: Listener,
        robot: RobotFile,
        clock: Clock,
        heard: Callable[[str, News], None],
        warn: Callable[[str], None],
    ) -> None:
        """`heard(topic, news)` is called after each reading, `warn` with what cannot be heard."""
        self._node, self._robot, self._clock = node, robot, clock
        self._heard = heard
        self._warn = warn
        self._readers = tuple(self._make_readers())
        self._subscriptions: dict[tuple[str, str], _Subscription] = {}  # by full topic and type
        self._periods: dict[object, Period] = {}
        self._graces: dict[object, float | None] = {}  # see Battery
        self._publishers: dict[object, frozenset[str]] = {}  # nodes, fully qualified
        self.faults: dict[str, str] = {}  # why a topic, or one of its publishers, is not heard
        self.battery = Battery()
        self.motion = Motion()
        self.gauges = tuple(Reading(gauge) for gauge in robot.gauges)
        self.charge: tuple[tuple[float, float], ...] = ()  # (s, %): never more than _SAMPLES

    def look(self) -> None:
        """(Re)subscribe to what is published now."""
        faults: dict[str, str] = {}
        wanted: dict[tuple[str, str], list[_Reader]] = {}  # by full topic and type
        published: dict[str, Sequence[Any]] = {}  # its publishers, by full topic
        for reader in self._readers:
            topic = self._node.resolve_topic_name(reader.topic)
            if topic not in published:
                published[topic] = self._node.get_publishers_info_by_topic(topic)
            if (kind := self._usable(reader, published[topic], faults)) is not None:
                wanted.setdefault((topic, kind), []).append(reader)
        for key in [key for key in self._subscriptions if key not in wanted]:
            # what nobody publishes any more is listened to all the same: it may come back
            if published[key[0]]:
                self._node.destroy_subscription(self._subscriptions.pop(key).subscription)
        for key, readers in wanted.items():
            self._subscribe(key, readers, published[key[0]])
        self.battery = self.battery._replace(grace=self._grace("battery"))
        self.motion = replace(self.motion, grace=self._grace("motion"))
        self.gauges = tuple(
            reading._replace(grace=self._grace(place)) for place, reading in enumerate(self.gauges)
        )
        for topic, fault in faults.items():
            if self.faults.get(topic) != fault:
                self._warn(fault)
        self.faults = faults

    def _make_readers(self) -> Iterator[_Reader]:
        battery, motion = self._robot.battery, self._robot.motion
        if battery is not None:
            types = {kind: _given(fields) for kind, fields in battery.types.items()}
            yield _Reader("battery", battery.topic, types, self._on_battery)
        if motion is not None:
            types = {kind: _given(fields) for kind, fields in motion.types.items()}
            yield _Reader("motion", motion.topic, types, self._on_motion)
        for place, gauge in enumerate(self._robot.gauges):
            types = {gauge.type: {"value": gauge.field}}
            yield _Reader(place, gauge.topic, types, partial(self._on_gauge, place))

    def measure_anew(self, node: str, old: object, new: object) -> None:
        """Measure every period anew: a parameter has changed, and may be one of them.

        Silence is judged by what was known until then.

        Args:
            node: The node that has the parameter, fully qualified.
            old: What it was.
            new: What it is.
        """
        for key, period in self._periods.items():
            is_its = node in self._publishers.get(key, ())
            self._periods[key] = period.measured_again(old if is_its else None, new)
        known = {key: period.typical for key, period in self._periods.items()}
        fixed = self._fixed(self._robot.battery), self._fixed(self._robot.motion)
        self.battery = self.battery._replace(period=fixed[0] or known.get("battery"))
        self.motion = replace(self.motion, period=fixed[1] or known.get("motion"))
        self.gauges = tuple(
            reading._replace(period=known.get(place)) for place, reading in enumerate(self.gauges)
        )

    def kept(self) -> Kept:
        """The readings, to be put back."""
        return self.battery, self.motion, self.gauges, self.charge, dict(self._periods)

    def put_back(self, kept: Kept) -> None:
        """As it was when they were kept."""
        self.battery, self.motion, self.gauges, self.charge, periods = kept
        self._periods = dict(periods)

    def _usable(
        self, reader: _Reader, publishers: Sequence[Any], faults: dict[str, str]
    ) -> str | None:
        """Return the type that a reader can read of its topic now; None: there is none.

        Args:
            reader: Its topic's publishers are noted, and how long it may be silent.
            publishers: Those of its topic.
            faults: What is wrong with a topic is put into it.
        """
        self._publishers[reader.key] = frozenset(
            in_namespace(info.node_namespace, info.node_name) for info in publishers
        )
        if not publishers:
            self._graces[reader.key] = LEAST_SILENCE  # nobody is there to say more
            return None
        kinds: list[str] = sorted({info.topic_type for info in publishers})
        types = reader.types
        known = {kind: message_classes.load(kind) for kind in kinds if kind in types}
        lacking = {k: _lacking(reader.topic, k, known[k], types[k]) for k in known}
        usable = [kind for kind in known if not lacking[kind]]
        said = next(filter(None, lacking.values()), "")
        said = said or mismatch.unexpected_type(reader.topic, kinds, types)
        if said:
            faults.setdefault(reader.topic, said)
        if not usable:
            return None
        # what is latched may be said once, and holds while its publisher is there
        self._graces[reader.key] = None if _is_latched(publishers) else UNMEASURED
        return usable[0]

    def _subscribe(
        self, key: tuple[str, str], readers: Sequence[_Reader], publishers: Sequence[Any]
    ) -> None:
        """Have one subscription for all readers of a topic and type, with a QoS that fits.

        Two would be recorded twice, and counted twice as often as messages come.
        """
        topic, kind = key
        latched = _is_latched(publishers)
        reliable = all(
            info.qos_profile.reliability == ReliabilityPolicy.RELIABLE for info in publishers
        )
        made = _Subscription((reliable, latched), tuple(reader.key for reader in readers))
        old = self._subscriptions.get(key)
        if old is not None and old[:2] == made[:2]:
            return
        if old is not None:
            self._node.destroy_subscription(old.subscription)
        qos = QoSProfile(
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            # where the last message is kept; of others a subscriber that asks for it hears nothing
            durability=(DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE),
        )

        def on_message(message: Any) -> None:
            news: dict[str, News] = {}  # by the topic's name in the robot file
            for reader in readers:
                said = reader.callback(message, reader.types[kind])
                news[reader.topic] = max(news.get(reader.topic, said), said, key=_WEIGHT)
            for name, said in news.items():
                self._heard(name, said)

        subscription = self._node.listen_quietly(message_classes.load(kind), topic, on_message, qos)
        self._subscriptions[key] = made._replace(subscription=subscription)

    def _on_battery(self, message: Any, fields: Mapping[str, Fields]) -> News:
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
            received=now,
            period=self._fixed(self._robot.battery) or self._measured("battery", now),
            unreadable=unreadable,
            grace=self._grace("battery"),
        )
        self._sample(now, turned=charging != self.battery.charging)
        return _news(last, self.battery, *_BATTERY)

    def _on_motion(self, message: Any, fields: Mapping[str, Fields]) -> News:
        assert self._robot.motion is not None
        found = {name: read(field, message) for name, field in fields.items()}
        now, last = self._clock.monotonic(), self.motion
        self.motion = Motion(
            count=integer(found.get("count")),
            speed=number(found.get("speed"), -_MOST_SPEED, _MOST_SPEED),
            moving=flag(found.get("moving")),
            stopped=flag(found.get("stopped")),
            received=now,
            period=self._fixed(self._robot.motion) or self._measured("motion", now),
            grace=self._grace("motion"),
        )
        return _news(last, self.motion, *_MOTION)

    def _on_gauge(self, place: int, message: Any, fields: Mapping[str, Fields]) -> News:
        gauge, last, now = self._robot.gauges[place], self.gauges[place], self._clock.monotonic()
        value = read(fields["value"], message)
        reading = number(value, *_range(gauge))
        unreadable = "" if reading is not None else as_received(value)
        if unreadable and not last.unreadable:
            self._warn(f"{gauge.topic}: {gauge.title} {unreadable} is not {_range_text(gauge)}")
        period, grace = self._measured(place, now), self._grace(place)
        new = Reading(gauge, reading, now, period, unreadable, grace)
        self.gauges = (*self.gauges[:place], new, *self.gauges[place + 1 :])
        return _news(last, new, *_GAUGE)

    def _measured(self, key: object, now: float) -> float | None:
        self._periods[key] = self._periods.get(key, Period()).heard(now)
        return self._periods[key].typical

    def _grace(self, key: object) -> float | None:
        """Return the allowed silence in s of a topic whose period is not known; None: any."""
        if self._graces.get(key, UNMEASURED) != UNMEASURED:
            return self._graces[key]
        return self._periods.get(key, Period()).grace

    def _fixed(self, topic: Any) -> float | None:
        return None if topic is None else topic.period

    def _sample(self, now: float, *, turned: bool) -> None:
        """Keep the charge for its trend; what came before it turned says nothing about it."""
        percentage, kept = self.battery.percentage, self.charge
        if percentage is not None and kept:  # another battery, or its node was restarted
            rise = percentage - kept[-1][1]
            turned = turned or (-rise if self.battery.charging else rise) > _JUMP
        kept = () if turned else kept
        if percentage is not None and (not kept or now - kept[-1][0] >= _SAMPLE_PERIOD):
            self.charge = (*kept[-_SAMPLES + 1 :], (now, percentage))


def _news(last: object, new: object, words: attrgetter[Any], numbers: attrgetter[Any]) -> News:
    if words(last) != words(new):
        return News.WORDS
    return News.NONE if numbers(last) == numbers(new) else News.NUMBERS


def _is_latched(publishers: Sequence[Any]) -> bool:
    """Return whether all of them keep their last message for who subscribes later."""
    return all(
        info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for info in publishers
    )


def _given(fields: Any) -> dict[str, Fields]:
    """The readings that a message type has, by name."""
    return {name: field for name, field in vars(fields).items() if field is not None}


def _lacking(topic: str, kind: str, message_class: Any, fields: Mapping[str, Fields]) -> str:
    """Why a type cannot be read: not installed, or without a field that the robot file names."""
    if message_class is None:
        return mismatch.not_installed(topic, kind)
    named = [field for given in fields.values() for field in fields_of(given)]
    wanted = [(field.where, field.field) for field in named]
    return mismatch.unknown_field(kind, wanted, messages.paths(message_class))


def _range(gauge: Gauge) -> tuple[float, float]:
    low = -_MOST if gauge.low is None else gauge.low
    return low, _MOST if gauge.high is None else gauge.high


def _range_text(gauge: Gauge) -> str:
    limited = gauge.low is not None and gauge.high is not None
    return f"within {gauge.low:g} .. {gauge.high:g}" if limited else "a number of this gauge"
