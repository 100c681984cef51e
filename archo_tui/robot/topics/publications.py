"""The messages that a person publishes from this console. ROS thread only.

What could move the robot ends the moment a STOP is read, and publishes nothing behind it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from archo_tui.base.errors import ArchoError
from archo_tui.robot.graph.endpoints import is_matched
from archo_tui.robot.messages.types import name_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.runtime import Runtime

CANCEL = "cancel"  # Why one was ended.
PAUSE = "a pause of the console"
_LOOK_PERIOD = 0.02  # Seconds between two looks whether a STOP was read.
_LONGEST_GAP = 1.0  # Seconds without a look: this process was suspended, and read no STOP.
_LINGER = 0.5  # Seconds that a publisher stays behind its last message, which may be on its way.
_FIND_TIME = 1.0  # Seconds in which a subscriber is found before the first message.
_FIND_PERIOD = 0.05
# Types whose default value, no speed, is published when the publishing is ended.
_SPEEDS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


class Publications:
    """All publications of this console that run."""

    def __init__(self) -> None:
        self.active: tuple[Publication, ...] = ()  # Replaced, so any thread may read it.

    def end_all(self, why: str) -> str:
        """End all that run; return what was ended, "" for nothing."""
        ended = self.active
        for publication in ended:
            publication.end(why)
        return ", ".join(publication.topic for publication in ended)


class Publication:
    """A message that is published `times` times at `rate` Hz; for ever if `times` is None.

    `on_end` is called when the last one has left, or `why_end` says why, or `end` is called.
    """

    def __init__(
        self,
        runtime: Runtime,
        others: Publications,
        topic: str,
        message: Any,
        rate: float,
        times: int | None,
        why_end: Callable[[], str],  # Returns why no message may follow; "" if one may.
        on_end: Callable[[Publication], None],
    ) -> None:
        self._node, self._clock, self._others = runtime.node, runtime.clock, others
        self.topic, self.rate, self.times = topic, rate, times
        self._message, self._type = message, name_of(type(message))
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        # The header has the time of each message, if nobody typed one.
        self._takes_time = stamp is not None and not (stamp.sec or stamp.nanosec)
        self._why_end, self._on_end = why_end, on_end
        self._timers: list[Any] = []
        self.count = 0  # Messages so far.
        self.looked: float | None = None  # Monotonic s of the last look; None before the first.
        self.ended = ""  # Why it was ended; "" while it runs, and if all times are over.
        self.is_over = False

    @property
    def text(self) -> str:
        """The verb as it runs: `pub /cmd_vel, at 10 Hz`."""
        return f"pub {self.topic}, at {self.rate:g} Hz"

    @property
    def outcome(self) -> Outcome:
        """The outcome of one that is over."""
        count = f"{self.count} message{'s' * (self.count != 1)}"
        if self.ended == CANCEL and self.times is None:  # There is no other end.
            return Outcome(Code.DONE, f"ended after {count}")
        if self.ended:
            return Outcome(Code.CANCELLED, f"ended by {self.ended} after {count}")
        return Outcome(Code.DONE, f"published {count}")

    async def begin(self) -> None:
        """Publish the first message, once a subscriber was found or is not expected any more."""
        node, subscriptions = self._node, self._subscriptions()
        ends = node.get_publishers_info_by_topic(self.topic)
        ends += node.get_subscriptions_info_by_topic(self.topic)
        others = {end.topic_type for end in ends if end.node_name == node.get_name()} - {self._type}
        if others:  # Of a topic, DDS lets a participant have one type.
            why = f"this console has {self.topic} as {', '.join(sorted(others))} now"
            raise ArchoError(f"{why}: it cannot publish {self._type} there as well")
        infos = [end for end in subscriptions if end.topic_type == self._type]
        kept = QoSDurabilityPolicy.TRANSIENT_LOCAL
        is_kept = any(info.qos_profile.durability == kept for info in infos)
        self._qos = QoSProfile(depth=10)
        self._qos.durability = kept if is_kept else QoSDurabilityPolicy.VOLATILE
        self._publisher = node.create_publisher(type(self._message), self.topic, self._qos)
        self.topic = self._publisher.topic_name
        self._others.active += (self,)
        waits = _FIND_TIME if infos else 0.0
        while waits > 0 and not (self.is_over or self._why_end()):
            if self._publisher.get_subscription_count():
                break
            await node.pause(_FIND_PERIOD)
            waits -= _FIND_PERIOD
        self._publish_next()
        if not self.is_over:
            self._timers = [
                node.create_steady_timer(1.0 / self.rate, self._publish_next),
                node.create_steady_timer(_LOOK_PERIOD, self._look),
            ]

    def _subscriptions(self) -> list[Any]:
        """Return the subscriptions of other nodes."""
        ends, own = self._node.get_subscriptions_info_by_topic(self.topic), self._node.get_name()
        return [end for end in ends if end.node_name != own]

    def subscriber_counts(self) -> tuple[int, int]:
        """Return how many subscriptions get the messages, and how many others the topic has."""
        ends = self._subscriptions()
        matched = sum(is_matched(self._type, self._qos, end) for end in ends)
        return matched, len(ends) - matched

    def _publish_next(self) -> None:
        self._look()
        if not self.is_over:
            self._publish(self._message)
            self.count += 1
            if self.count == self.times:
                self.end("")

    def _publish(self, message: Any) -> None:
        if self._takes_time:
            message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)

    def _look(self) -> None:
        now, before = self._clock.monotonic(), self.looked
        self.looked = now
        if before is not None and now - before > _LONGEST_GAP:
            self.end(PAUSE)
        elif why := self._why_end():
            self.end(why)

    def end(self, why: str) -> None:
        """End it, unless it is over; one of velocities is ended early by a zero one."""
        if self.is_over:
            return
        self.is_over, self.ended = True, why
        self._others.active = tuple(other for other in self._others.active if other is not self)
        for timer in self._timers:
            self._node.destroy_timer(timer)
        if why and self.count and self._type in _SPEEDS:
            self._publish(type(self._message)())
        self._on_end(self)

        def destroy() -> None:
            self._node.destroy_timer(timer)
            self._node.destroy_publisher(self._publisher)

        timer = self._node.create_steady_timer(_LINGER, destroy)
