"""The record of what the robot's side consists of, over which requests are functions."""

from __future__ import annotations

from collections.abc import Callable, Collection

from rclpy.clock import Clock as RosClock
from rclpy.timer import Timer

from archo_tui.clock import Clock
from archo_tui.robot.calls import Services
from archo_tui.robot.clients.changes import UnexplainedChanges
from archo_tui.robot.goals.client import Goals
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.graph.lifecycle import Lifecycles
from archo_tui.robot.graph.nodes import Nodes
from archo_tui.robot.graph.parameters import Parameters
from archo_tui.robot.node import Listener
from archo_tui.robot.readings.clocks import ClockOffsets, SimClock
from archo_tui.robot.readings.telemetry import Telemetry
from archo_tui.robot.reporter import Reporter
from archo_tui.robot.ros_thread import RosThread
from archo_tui.robot.snapshot_sender import SnapshotSender
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.sender import StopSender
from archo_tui.robot.topics.frames import FrameListener
from archo_tui.robot.topics.publications import Publications
from archo_tui.robot_file.model import RobotFile


class Parts:
    """The parts of the robot's side. Those that no comment names change on the ROS thread only.

    Requests read some of them on the event loop: names, parameters, the goal, the open STOP.
    """

    file: RobotFile
    clock: Clock  # Any thread.
    begun: float  # When this console started, in monotonic seconds.
    watching: bool  # True if every request that changes something is refused.
    own_nodes: Callable[[], Collection[str]]  # The full names of the nodes that run here.
    unended_nodes: Callable[[], Collection[str]]  # Those of them whose code may still run.
    faults: dict[str, str]  # Why a name of the robot file is not used, by that name.

    thread: RosThread  # Any thread.
    node: Listener
    timer_clock: RosClock  # The robot's time may stand still, or jump.
    services: Services
    snapshots: SnapshotSender
    reporter: Reporter

    graph: Graph
    checks: InterfaceChecks
    nodes: Nodes
    parameters: Parameters
    lifecycles: Lifecycles

    telemetry: Telemetry
    frames: FrameListener
    clock_offsets: ClockOffsets
    sim_clock: SimClock
    changes: UnexplainedChanges

    stops: Stops  # The STOPs that were read. Any thread.
    stop_sender: StopSender
    goals: Goals
    publications: Publications
    goal_timer: Timer  # Checks the goals while any runs.

    @property
    def snapshot(self) -> Snapshot:
        """The newest snapshot, also if it was not delivered yet. Any thread."""
        return self.snapshots.mailbox.latest
