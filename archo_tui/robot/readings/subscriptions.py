"""The subscriptions to the topics with readings: one for each topic, of its type and QoS."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from archo_tui.errors import in_one_line
from archo_tui.robot.graph.endpoints import fitting_qos, is_latched
from archo_tui.robot.messages.period import LEAST_SILENCE
from archo_tui.robot.messages.types import field_paths, load_class
from archo_tui.robot.messages.values import Fields
from archo_tui.robot.node import ConsoleNode
from archo_tui.robot.state.graph import in_namespace
from archo_tui.robot_file import check
from archo_tui.robot_file.model import fields_of


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
    """A subscription and what it was made for."""

    qos: tuple[ReliabilityPolicy, DurabilityPolicy]  # Its reliability and its durability.
    keys: tuple[object, ...]  # The keys of its readers.
    subscription: Any = None  # rclpy's object; None if rclpy made none.
    fault: str = ""  # Why rclpy made none; "" if it did.


class ReadingSubscriptions:
    """The subscriptions to the topics of the robot file's readings. ROS thread only."""

    def __init__(
        self,
        node: ConsoleNode,
        readers: Sequence[Reader],
        on_reading: Callable[[str, bool], None],
        on_stamp: Callable[[str, Any], None],
        warn: Callable[[str], None],
    ) -> None:
        self._node, self._readers = node, tuple(readers)
        self._on_reading, self._on_stamp, self._warn = on_reading, on_stamp, warn
        # By the full name of the topic, and its type.
        self._subscriptions: dict[tuple[str, str], _Subscription] = {}
        # Why a topic or one of its publishers is not read, by the topic in the robot file.
        self.faults: dict[str, str] = {}
        # The full names of the nodes that publish each reading, by key.
        self.publishers: dict[object, frozenset[str]] = {}
        # The ids of their publishers, by key: a node that is restarted has new ones.
        self.endpoints: dict[object, frozenset[bytes]] = {}
        # The silence in seconds that is allowed without a period, by key; None for any.
        self.graces: dict[object, float | None] = {}

    def update(self) -> None:
        """Subscribe to what is published now, with its types and QoS, and update the attributes.

        Each new fault is passed to `warn`. A subscription whose type nobody publishes any more
        ends; that of a topic without any publisher stays.
        """
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
        for key, readers in wanted.items():
            self._subscribe(key, readers, published[key[0]])
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
        self.publishers[reader.key] = frozenset(
            in_namespace(info.node_namespace, info.node_name) for info in publishers
        )
        self.endpoints[reader.key] = frozenset(bytes(info.endpoint_gid) for info in publishers)
        if not publishers:
            self.graces[reader.key] = LEAST_SILENCE  # Nobody is left to send more.
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
            self.graces[reader.key] = None
        else:
            self.graces.pop(reader.key, None)
        return usable[0]

    def _subscribe(
        self, key: tuple[str, str], readers: Sequence[Reader], publishers: Sequence[Any]
    ) -> None:
        """Make one subscription for all readers of a topic and type, with a QoS that fits.

        With two, each message would be recorded and counted twice.
        """
        topic, kind = key
        qos = fitting_qos(publishers)
        made = _Subscription(
            (qos.reliability, qos.durability), tuple(reader.key for reader in readers)
        )
        old = self._subscriptions.get(key)
        if old is not None and old[:2] == made[:2]:
            return
        if old is not None:
            self._end(old)

        def on_message(message: Any) -> None:
            header = getattr(message, "header", None)
            if header is not None and hasattr(header, "stamp"):
                self._on_stamp(topic, header.stamp)
            changed: dict[str, bool] = {}  # By the topic's name in the robot file.
            for reader in readers:
                new = reader.callback(message, {} if reader.types is None else reader.types[kind])
                changed[reader.topic] = changed.get(reader.topic, False) or new
            for name, has_changed in changed.items():
                self._on_reading(name, has_changed)

        message_class = load_class(kind)
        try:
            subscription = self._node.listen_quietly(message_class, topic, on_message, qos)
        except Exception as error:  # Fast DDS allows one type of a topic in a process.
            fault = check.not_subscribed(readers[0].topic, kind, in_one_line(error))
            self._subscriptions[key] = made._replace(fault=fault)
        else:
            self._subscriptions[key] = made._replace(subscription=subscription)

    def _end(self, ended: _Subscription) -> None:
        if ended.subscription is not None:
            self._node.destroy_subscription(ended.subscription)


def _lacking(topic: str, kind: str, message_class: Any, fields: Mapping[str, Fields]) -> str:
    """Return why a type cannot be read: not installed, or without a field of the readers; or ""."""
    if message_class is None:
        return check.not_installed(topic, kind)
    named = [field for given in fields.values() for field in fields_of(given)]
    wanted = [(field.where, field.field) for field in named]
    return check.unknown_field(kind, wanted, field_paths(message_class))
