"""The check of the goals that run: their silence, and the lengths of their ways."""

from __future__ import annotations

from rclpy.clock import Clock as RosClock
from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.goals.machine import FARTHEST
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.parameters import Parameters
from archo_tui.robot.readings.telemetry import Telemetry
from archo_tui.robot.snapshot_sender import SnapshotSender
from archo_tui.robot.state import linked_number
from archo_tui.robot_file.model import GoalKind, ParameterRef

WATCH_PERIOD = 0.2  # Seconds between two checks of the goals that run.


class GoalWatcher:
    """The check of the goals that run, five times a second while any does. ROS thread only."""

    def __init__(
        self,
        node: Node,
        timer_clock: RosClock,
        clock: Clock,
        goals: Goals,
        graph: Graph,
        parameters: Parameters,
        telemetry: Telemetry,
        snapshots: SnapshotSender,
    ) -> None:
        self._clock, self._goals, self._graph, self._parameters = clock, goals, graph, parameters
        self._telemetry, self._snapshots = telemetry, snapshots
        self._timer = node.create_timer(WATCH_PERIOD, self.check, clock=timer_clock)
        self._timer.cancel()

    def on_change(self, is_new_phase: bool) -> None:
        """Begin to check the goals, if that is not done yet, and send a snapshot."""
        if self._timer.is_canceled():
            self._timer.reset()
        if is_new_phase:
            self._snapshots.send()
        else:  # After feedback, so that the motion which is reported beside it is shown with it.
            self._snapshots.send_soon()

    def check(self) -> None:
        """Check the goals that run; stop the timer if none does.

        Lengths of ways are set where they became known. Silent goals become LOST, and goals without
        a server GONE.
        """
        if not self._goals.running:
            self._timer.cancel()
            return
        self._goals.check(self._clock.monotonic(), self._telemetry.motion, self.way_length)

    def way_length(self, kind: GoalKind) -> float | None:
        """Return the length of the whole way for a kind of goal, by the robot file."""
        length = None if kind.remaining is None else kind.remaining.length
        if isinstance(length, ParameterRef):
            parameters, namespace = self._parameters.all(), self._graph.namespace
            return linked_number(parameters, namespace, length, 0.0, FARTHEST)
        return length
