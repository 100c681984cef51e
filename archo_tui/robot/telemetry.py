"""Hears battery and motor, with the type and QoS that the publishers have. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from archo_tui.clock import Clock
from archo_tui.robot import interfaces
from archo_tui.robot.period import Period
from archo_tui.robot.readings import (
    BATTERY_TYPES,
    MOTOR_TYPES,
    as_received,
    flag,
    integer,
    number,
)
from archo_tui.robot.state import BATTERY, MOTOR, Battery, Motor
from archo_tui.robot.text import harmless

_DEPTH = 10
_SAMPLE_PERIOD = 1.0  # s between two samples of the charge that are kept
_SAMPLES = 300
_JUMP = 0.5  # % in the wrong direction that is more than noise
_MOST_VOLTS, _MOST_SPEED = 1e4, 1e4  # V, m/s; beyond that it is no reading


class Telemetry:
    """The last battery and motor readings."""

    def __init__(
        self,
        node: Node,
        clock: Clock,
        heard: Callable[[str, bool], None],
        warn: Callable[[str], None],
    ) -> None:
        """`heard(topic, news)` is called after each reading, `warn` with what cannot be heard.

        Without news nothing differs but its time.
        """
        self._node, self._clock = node, clock
        self._heard = heard
        self._warn = warn
        self._subscriptions: dict[str, tuple[tuple[str, bool], Any]] = {}
        self._periods = {BATTERY: Period(), MOTOR: Period()}
        self.faults: dict[str, str] = {}  # why a topic, or one of its publishers, is not heard
        self.battery = Battery()
        self.motor = Motor()
        self.charge: tuple[tuple[float, float], ...] = ()  # (s, %): never more than _SAMPLES

    def look(self) -> None:
        """(Re)subscribe to what is published now."""
        self._follow(BATTERY, BATTERY_TYPES, self._on_battery)
        self._follow(MOTOR, MOTOR_TYPES, self._on_motor)

    def measure_anew(self) -> None:
        """The robot may have another pace from now on: silence is judged when that is known."""
        self._periods = {topic: Period() for topic in self._periods}
        self.battery = replace(self.battery, period=None)
        self.motor = replace(self.motor, period=None)

    def _follow(
        self,
        topic: str,
        types: Mapping[str, Mapping[str, str]],
        callback: Callable[[Any, Mapping[str, str]], None],
    ) -> None:
        publishers = self._node.get_publishers_info_by_topic(topic)
        if not publishers:
            return  # keep listening: the publisher may come back
        kinds = sorted({info.topic_type for info in publishers})
        known = {kind: interfaces.load(kind) for kind in kinds if kind in types}
        usable = [kind for kind in known if known[kind] is not None]
        self._set_fault(topic, self._fault(topic, kinds, usable, types))
        old = self._subscriptions.get(topic)
        if not usable:
            if old is not None:
                self._node.destroy_subscription(self._subscriptions.pop(topic)[1])
            return
        kind = usable[0]
        reliable = all(
            info.qos_profile.reliability == ReliabilityPolicy.RELIABLE for info in publishers
        )
        wanted = (kind, reliable)
        if old is not None and old[0] == wanted:
            return
        if old is not None:
            self._node.destroy_subscription(old[1])
        qos = QoSProfile(
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.VOLATILE,
        )
        fields = types[kind]
        subscription = self._node.create_subscription(
            known[kind], topic, lambda message: callback(message, fields), qos
        )
        self._subscriptions[topic] = (wanted, subscription)

    def _fault(
        self, topic: str, kinds: list[str], usable: list[str], types: Mapping[str, Any]
    ) -> str:
        """What is wrong with the types of a topic's publishers, or an empty string."""
        for kind in kinds:
            if kind in types and kind not in usable:
                return f"{topic} is {kind}, which is not installed here"
            if kind not in types:
                return f"{topic} is {kind}: expected {' or '.join(types)}"
        return f"{topic} has several types: {', '.join(kinds)}" if len(kinds) > 1 else ""

    def _set_fault(self, topic: str, fault: str) -> None:
        if fault and self.faults.get(topic) != fault:
            self._warn(fault)
        self.faults.pop(topic, None)
        if fault:
            self.faults[topic] = fault

    def _on_battery(self, message: Any, fields: Mapping[str, str]) -> None:
        found = {name: getattr(message, path, None) for name, path in fields.items()}
        now, charging = self._clock.monotonic(), self.battery.charging
        percentage, before = found.get("percentage"), self.battery.unreadable
        reading = number(percentage, 0.0, 100.0)
        unreadable = "" if reading is not None else as_received(percentage)
        if unreadable and not before:
            self._warn(f"{BATTERY}: percentage {unreadable} is not within 0 .. 100")
        last = self.battery
        self.battery = Battery(
            percentage=reading,
            voltage=number(found.get("voltage"), 0.0, _MOST_VOLTS),
            charging=flag(found.get("charging")),
            health=harmless(str(found.get("health") or "")) or None,
            received=now,
            period=self._measured(BATTERY, now),
            unreadable=unreadable,
        )
        self._sample(now, turned=charging != self.battery.charging)
        self._heard(BATTERY, self.battery != replace(last, received=now))

    def _measured(self, topic: str, now: float) -> float | None:
        self._periods[topic] = self._periods[topic].heard(now)
        return self._periods[topic].seconds

    def _sample(self, now: float, *, turned: bool) -> None:
        """Keep the charge for its trend; what came before it turned says nothing about it."""
        percentage, kept = self.battery.percentage, self.charge
        if percentage is not None and kept:  # another battery, or its node was restarted
            rise = percentage - kept[-1][1]
            turned = turned or (-rise if self.battery.charging else rise) > _JUMP
        kept = () if turned else kept
        if percentage is not None and (not kept or now - kept[-1][0] >= _SAMPLE_PERIOD):
            self.charge = (*kept[-_SAMPLES + 1 :], (now, percentage))

    def _on_motor(self, message: Any, fields: Mapping[str, str]) -> None:
        found = {name: getattr(message, path, None) for name, path in fields.items()}
        now = self._clock.monotonic()
        last = self.motor
        self.motor = Motor(
            ticks=integer(found.get("ticks")),
            speed=number(found.get("speed"), -_MOST_SPEED, _MOST_SPEED),
            moving=flag(found.get("moving")),
            stopped=flag(found.get("stopped")),
            received=now,
            period=self._measured(MOTOR, now),
        )
        self._heard(MOTOR, self.motor != replace(last, received=now))
