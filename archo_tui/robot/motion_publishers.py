"""The publishers of the robot's motion, by which a restart of their node is noticed."""

from __future__ import annotations

from archo_tui.clock import Clock
from archo_tui.robot.graph import Graph
from archo_tui.robot_file.model import RobotFile

_RESTART = 3.0  # Seconds after a restart in which readings may differ because of it.


class MotionPublishers:
    """A memory of the publishers of the motion that were last on the graph. ROS thread only."""

    def __init__(self, file: RobotFile, graph: Graph, clock: Clock) -> None:
        """Create the memory, which is empty until the first `check`."""
        self._topic = None if file.motion is None else file.motion.topic
        self._graph, self._clock = graph, clock
        self._ids: frozenset[bytes] = frozenset()
        self._changed = float("-inf")  # When they last changed, in monotonic seconds.

    def check(self) -> None:
        """Remember the present publishers, and the time if others were there before.

        While there are none, the last ones are remembered.
        """
        if self._topic is None:
            return
        now, before = self._graph.publisher_ids(self._topic), self._ids
        if now and before and now != before:
            self._changed = self._clock.monotonic()
        self._ids = now or before

    def have_restarted(self) -> bool:
        """Check, and return True if other publishers appeared in the last three seconds."""
        self.check()
        return self._clock.monotonic() - self._changed <= _RESTART
