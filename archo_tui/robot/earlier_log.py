"""The log lines from before the start of the console. ROS thread only.

Nodes of rclcpp and rclpy publish /rosout transient local with a lifespan of 10 s (rcl's
`rcl_qos_profile_rosout_default`), so a subscription that is transient local, too, gets the lines of
the last 10 s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from archo_tui.clock import Clock
from archo_tui.robot.state import Event, level_word, logger_node

_WINDOW = 3.0  # Seconds after the start in which nodes are discovered and send what they keep.
_LIFESPAN = 10.0  # Seconds: see above.
_DEPTH = 1000  # As the publishers' own.


class EarlierLog:
    """A collector of the log lines that nodes wrote before the console started.

    During the first 3 s it receives them. Then it reports those of this robot's nodes once, in the
    order of their stamps, without lines that the other subscription received, too.
    """

    def __init__(
        self,
        node: Node,
        clock: Clock,
        is_ours: Callable[[str], bool],
        report: Callable[[Event], object],
    ) -> None:
        """Subscribe to /rosout as transient local, beside the console's other subscription.

        Args:
            node: The console's node. Its other subscription is volatile: a transient-local one
                would get nothing from a node whose publisher is volatile.
            clock: The console's clock.
            is_ours: Returns True for the full name of a node of this robot; lines of others are
                dropped.
            report: Adds an event to the log.
        """
        self._node, self._clock = node, clock
        self._is_ours, self._report = is_ours, report
        self._begun = clock.now()
        self._kept: dict[object, Any] = {}
        self._live: set[object] = set()  # Lines that came by the other subscription as well.
        qos = QoSProfile(
            depth=_DEPTH,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            reliability=ReliabilityPolicy.RELIABLE,
        )
        self._subscription: Any = node.create_subscription(Log, "/rosout", self._keep, qos)
        self._due = clock.monotonic() + _WINDOW

    def report_if_due(self) -> None:
        """Once 3 s have passed, report the collected lines, the oldest first, and unsubscribe.

        Before that, and after the first time, nothing is done.
        """
        if self._subscription is not None and self._clock.monotonic() >= self._due:
            self._end()

    def on_live_line(self, message: Log) -> None:
        """Record a line that the other subscription received, so that it is not reported twice."""
        if self._subscription is not None:
            self._live.add(_key(message))

    def _keep(self, message: Log) -> None:
        self._kept[_key(message)] = message

    def _end(self) -> None:
        self._node.destroy_subscription(self._subscription)
        self._subscription = None
        earlier = [self._kept[key] for key in self._kept.keys() - self._live]
        for message in sorted(earlier, key=_stamp):
            if self._is_ours(logger_node(message.name)):
                self._report(
                    Event(self._time(message), level_word(message.level), message.name, message.msg)
                )
        self._kept.clear()
        self._live.clear()

    def _time(self, message: Any) -> float:
        """Return the Unix time at which a line was logged, moved into the 10 s before the start.

        The clock of its computer may differ from this one's.
        """
        return min(max(_stamp(message), self._begun - _LIFESPAN), self._begun)


def _stamp(message: Any) -> float:
    """Return the Unix time in seconds at which a line was logged, by the clock of its computer."""
    return float(message.stamp.sec + message.stamp.nanosec * 1e-9)


def _key(message: Any) -> object:
    return message.stamp.sec, message.stamp.nanosec, message.name, message.msg
