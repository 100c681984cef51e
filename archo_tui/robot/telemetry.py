"""Hears battery and motor, with the type and QoS that the publishers have. ROS thread only."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from archo_tui.clock import Clock
from archo_tui.robot import interfaces
from archo_tui.robot.state import BATTERY, MOTOR, Battery, Motor

_DEPTH = 10
_SAMPLE_PERIOD = 1.0  # s between two samples of the charge that are kept
_SAMPLES = 300
_JUMP = 0.5  # % in the wrong direction that is more than noise


class Telemetry:
    """The last battery and motor readings."""

    def __init__(
        self,
        node: Node,
        clock: Clock,
        changed: Callable[[str], None],
        warn: Callable[[str], None],
    ) -> None:
        """`changed(topic)` is called after each reading, `warn` with what cannot be heard."""
        self._node, self._clock = node, clock
        self._changed = changed
        self._warn = warn
        self._subscriptions: dict[str, tuple[tuple[str, bool], Any]] = {}
        self._unknown: set[str] = set()  # types that the operator was warned about
        self.battery = Battery()
        self.motor = Motor()
        self.charge: tuple[tuple[float, float], ...] = ()  # (s, %): never more than _SAMPLES

    def look(self) -> None:
        """(Re)subscribe to what is published now."""
        self._follow(BATTERY, self._on_battery)
        self._follow(MOTOR, self._on_motor)

    def _follow(self, topic: str, callback: Callable[[Any], None]) -> None:
        publishers = self._node.get_publishers_info_by_topic(topic)
        if not publishers:
            return  # keep listening: the publisher may come back
        kind = publishers[0].topic_type
        reliable = all(
            info.qos_profile.reliability == ReliabilityPolicy.RELIABLE for info in publishers
        )
        wanted = (kind, reliable)
        old = self._subscriptions.get(topic)
        if old is not None and old[0] == wanted:
            return
        message_class = interfaces.load(kind)
        if message_class is None:
            if kind not in self._unknown:
                self._unknown.add(kind)
                self._warn(f"cannot listen to {topic}: its type {kind} is not installed here")
            return
        if old is not None:
            self._node.destroy_subscription(old[1])
        qos = QoSProfile(
            depth=_DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.VOLATILE,
        )
        subscription = self._node.create_subscription(message_class, topic, callback, qos)
        self._subscriptions[topic] = (wanted, subscription)

    def _on_battery(self, message: Any) -> None:
        now = self._clock.monotonic()
        last, charging = self.battery.received, self.battery.charging
        percentage = getattr(message, "percentage", getattr(message, "data", None))
        self.battery = Battery(
            percentage=_number(percentage),
            voltage=_number(getattr(message, "voltage", None)),
            charging=getattr(message, "is_charging", None),
            health=getattr(message, "battery_health", None) or None,
            received=now,
            period=self.battery.period if last is None else min(now - last, 60.0),
        )
        self._sample(now, turned=charging != self.battery.charging)
        self._changed(BATTERY)

    def _sample(self, now: float, *, turned: bool) -> None:
        """Keep the charge for its trend; what came before it turned says nothing about it."""
        percentage, kept = self.battery.percentage, self.charge
        if percentage is not None and kept:  # another battery, or its node was restarted
            rise = percentage - kept[-1][1]
            turned = turned or (-rise if self.battery.charging else rise) > _JUMP
        kept = () if turned else kept
        if percentage is not None and (not kept or now - kept[-1][0] >= _SAMPLE_PERIOD):
            self.charge = (*kept[-_SAMPLES + 1 :], (now, percentage))

    def _on_motor(self, message: Any) -> None:
        self.motor = Motor(
            ticks=getattr(message, "encoder_ticks", None),
            speed=_number(getattr(message, "speed", None)),
            moving=getattr(message, "moving", None),
            stopped=getattr(message, "emergency_stopped", None),
            received=self._clock.monotonic(),
        )
        self._changed(MOTOR)


def _number(value: Any) -> float | None:
    """A finite number, or None: to a person NaN is the same as not reported."""
    if isinstance(value, (int, float)) and math.isfinite(value):
        return float(value)
    return None
