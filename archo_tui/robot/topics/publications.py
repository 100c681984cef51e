"""The messages that a person publishes from this console. ROS thread only.

What could move the robot ends the moment a STOP is read, and publishes nothing behind it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from archo_tui.errors import ArchoError
from archo_tui.robot.graph.endpoints import is_matched
from archo_tui.robot.messages.types import name_of
from archo_tui.robot.runtime import Runtime

_LOOK_PERIOD = 0.02  # Seconds between two looks whether a STOP was read.
_LONGEST_GAP = 1.0  # Seconds without a look: this process was suspended, and read no STOP.
_LINGER = 0.5  # Seconds that a publisher stays behind its last message, which may be on its way.
_FIND_TIME = 1.0  # Seconds in which a subscriber is found before the first message.
_FIND_PERIOD = 0.05
# Types whose default value, no speed, is published when the publishing is ended.
_SPEEDS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


class Publication:
    """A message that is published `times` times at `rate` Hz; for ever if `times` is None."""

    def __init__(
        self,
        publisher: Any,
        qos: QoSProfile,
        message: Any,
        rate: float,
        times: int | None,
        why_end: Callable[[], str],  # Returns why no message may follow; "" if one may.
        on_end: Callable[[Publication], None],
        stamp: Callable[[], Any] | None,  # Returns the time for the header; None: it is typed.
    ) -> None:
        self.publisher, self.message, self.rate, self.times = publisher, message, rate, times
        self.qos = qos
        self.why_end, self.on_end, self._stamp = why_end, on_end, stamp
        self.topic: str = publisher.topic_name
        self.timers: list[Any] = []
        self.count = 0  # Messages so far.
        self.looked: float | None = None  # Monotonic s of the last look; None before the first.
        self.ended = ""  # Why it was ended; "" while it runs, and if all times are over.
        self.is_over = False

    @property
    def text(self) -> str:
        """The verb as it runs: `pub /cmd_vel, at 10 Hz`."""
        return f"pub {self.topic}, at {self.rate:g} Hz"

    def publish(self, message: Any) -> None:
        """Publish a message, with the present time in its header if nobody typed one."""
        if self._stamp is not None:
            message.header.stamp = self._stamp()
        self.publisher.publish(message)


class Publications:
    """All publications of this console that run."""

    def __init__(self, runtime: Runtime) -> None:
        self._node, self._clock = runtime.node, runtime.clock
        self.active: tuple[Publication, ...] = ()  # Replaced, so any thread may read it.

    async def begin(
        self,
        topic: str,
        message: Any,
        rate: float,
        times: int | None,
        why_end: Callable[[], str],  # Returns why no message may follow; "" if one may.
        on_end: Callable[[Publication], None],
        *,
        takes_time: bool,  # The header has the time of each message.
    ) -> Publication:
        """Publish the first message, once a subscriber was found or is not expected any more."""
        kind = name_of(type(message))
        ends = (*self._node.get_publishers_info_by_topic(topic), *self._ends(topic))
        own = self._node.get_name()
        others = {end.topic_type for end in ends if end.node_name == own} - {kind}
        if others:  # Of a topic, DDS lets a participant have one type.
            why = f"this console has {topic} as {', '.join(sorted(others))} now"
            raise ArchoError(f"{why}: it cannot publish {kind} there as well")
        infos = [end for end in self._subscriptions(topic) if end.topic_type == kind]
        kept = QoSDurabilityPolicy.TRANSIENT_LOCAL
        is_kept = any(info.qos_profile.durability == kept for info in infos)
        durability = kept if is_kept else QoSDurabilityPolicy.VOLATILE
        qos = QoSProfile(depth=10, durability=durability)
        publisher = self._node.create_publisher(type(message), topic, qos)
        stamp = self._node.get_clock().now if takes_time else None
        publication = Publication(
            *(publisher, qos, message, rate, times, why_end, on_end),
            None if stamp is None else lambda: stamp().to_msg(),
        )
        self.active = (*self.active, publication)
        waits = _FIND_TIME if infos else 0.0
        while waits > 0 and not (publication.is_over or why_end()):
            if publisher.get_subscription_count():
                break
            await self._node.pause(_FIND_PERIOD)
            waits -= _FIND_PERIOD

        def next_message() -> None:
            look()
            if not publication.is_over:
                publication.publish(message)
                publication.count += 1
                if publication.count == times:
                    self.end(publication, "")

        def look() -> None:
            now, before = self._clock.monotonic(), publication.looked
            publication.looked = now
            if before is not None and now - before > _LONGEST_GAP:
                self.end(publication, "a pause of the console")
            elif why := why_end():
                self.end(publication, why)

        next_message()
        if not publication.is_over:
            publication.timers = [
                self._node.create_steady_timer(1.0 / rate, next_message),
                self._node.create_steady_timer(_LOOK_PERIOD, look),
            ]
        return publication

    def _ends(self, topic: str) -> list[Any]:
        ends: list[Any] = self._node.get_subscriptions_info_by_topic(topic)
        return ends

    def _subscriptions(self, topic: str) -> list[Any]:
        """Return the subscriptions of other nodes."""
        return [end for end in self._ends(topic) if end.node_name != self._node.get_name()]

    def subscriber_counts(self, publication: Publication) -> tuple[int, int]:
        """Return how many subscriptions get the messages, and how many others the topic has."""
        kind, qos = name_of(type(publication.message)), publication.qos
        ends = self._subscriptions(publication.topic)
        matched = sum(is_matched(kind, qos, end) for end in ends)
        return matched, len(ends) - matched

    def end(self, publication: Publication, why: str) -> None:
        """End a publication, unless it is over; one of velocities is ended early by a zero one."""
        if publication.is_over:
            return
        publication.is_over, publication.ended = True, why
        self.active = tuple(other for other in self.active if other is not publication)
        for timer in publication.timers:
            self._node.destroy_timer(timer)
        if why and publication.count and name_of(type(publication.message)) in _SPEEDS:
            publication.publish(type(publication.message)())
        publication.on_end(publication)

        def destroy() -> None:
            self._node.destroy_timer(timer)
            self._node.destroy_publisher(publication.publisher)

        timer = self._node.create_steady_timer(_LINGER, destroy)

    def end_all(self, why: str) -> str:
        """End all that run; return what was ended, "" for nothing."""
        ended = self.active
        for publication in ended:
            self.end(publication, why)
        return ", ".join(publication.topic for publication in ended)
