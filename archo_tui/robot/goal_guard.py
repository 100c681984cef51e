"""The decision whether a goal may be sent now.

A goal is not sent while a STOP is open, holds, or is uncertain, nor to several servers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.readings.telemetry import Telemetry
from archo_tui.robot.state import Latch, Snapshot
from archo_tui.robot.stop.gate import HELD, HOLDS, UNCERTAIN, UNCONFIRMED, Gate
from archo_tui.robot.stop_sender import StopSender
from archo_tui.robot_file import mismatch
from archo_tui.robot_file.model import GoalKind, RobotFile


class GoalGuard:
    """The last check by STOP and robot file whether a goal may be sent. ROS thread only."""

    def __init__(
        self,
        file: RobotFile,
        graph: Graph,
        stop: StopSender,
        telemetry: Telemetry,
        faults: Callable[[], Mapping[str, str]],
    ) -> None:
        self._file, self._graph, self._stop_sender = file, graph, stop
        self._telemetry, self._faults = telemetry, faults

    def refusal(self, kind: GoalKind, gate: Gate, *, queued: bool) -> Outcome | None:
        """Return why a goal may not be sent now; None if it may be.

        Reasons are a STOP, several servers of its action, or a fault of the action. The nodes that
        hold the STOP are checked again, which may make the STOP uncertain.
        """
        stop_state = self._stop_state()
        if queued and (
            self._stop_sender.stop.open is not None
            or stop_state.says_stopped
            or stop_state.stop_holds
        ):
            return Outcome(Code.HELD, HELD)
        # The STOP may not have reached the robot, and would not be sent again behind a goal.
        if self._stop_sender.stop.open is not None and not gate.is_shut:
            return Outcome(Code.REFUSED, UNCONFIRMED)
        # Its node may have been restarted since the last poll.
        self._stop_sender.check_holders()
        if self._stop_sender.stop.latch is Latch.UNCERTAIN and not gate.is_shut:
            return Outcome(Code.HELD, HELD) if queued else Outcome(Code.REFUSED, UNCERTAIN)
        if stop_state.stop_holds and not gate.is_shut:
            return Outcome(Code.REFUSED, HOLDS)
        servers = self._graph.duplicate_servers(kind.action)
        if servers:  # Also of an action that is not in the robot file.
            return Outcome(Code.REFUSED, mismatch.duplicate_servers(kind.action, servers))
        fault = self._faults().get(kind.action)
        return None if fault is None else Outcome(Code.REFUSED, fault)

    def _stop_state(self) -> Snapshot:
        """Return a snapshot that holds only what is known now about a STOP."""
        return Snapshot(
            file=self._file,
            motion=self._telemetry.motion,
            latch=self._stop_sender.stop.latch,
            released=self._stop_sender.stop.released,
        )
