"""The check of what follows a STOP: repeats, cancels, goals that run on. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock as RosClock
from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.robot.goals import Goals
from archo_tui.robot.outcome import Code
from archo_tui.robot.snapshot_sender import SnapshotSender
from archo_tui.robot.stopping import Stopping
from archo_tui.robot.telemetry import Telemetry
from archo_tui.robot.thread import RosThread

_PERIOD = 0.2  # Seconds between two checks while a STOP is open or a goal runs.


class StopWatcher:
    """The check of a STOP and of the goals from before it, five times a second.

    Attributes:
        still_running: The names of the running goals that began before a confirmed STOP, and should
            have ended by now.
    """

    def __init__(
        self,
        node: Node,
        timer_clock: RosClock,
        clock: Clock,
        goals: Goals,
        stopping: Stopping,
        telemetry: Telemetry,
        snapshots: SnapshotSender,
        thread: Callable[[], RosThread],
        report: Callable[[str, Code], None],
    ) -> None:
        self._clock, self._goals, self._stopping = clock, goals, stopping
        self._telemetry, self._snapshots = telemetry, snapshots
        self._thread, self._report = thread, report
        self.still_running: tuple[str, ...] = ()
        self._timer = node.create_timer(_PERIOD, self.check, clock=timer_clock)
        self._timer.cancel()

    def begin(self) -> None:
        """Start the timer, since a STOP or a goal may have begun."""
        if self._timer.is_canceled():
            self._timer.reset()

    def check(self) -> None:
        """Do what `Stopping` asks for at this moment; end the timer if nothing is left to do."""
        stopping, goals, motion = self._stopping, self._goals, self._telemetry.motion
        if not goals.running and stopping.open is None:
            self._timer.cancel()
            self._set_still_running(())
            return
        if stopping.cancels_before is not None:
            goals.cancel_from_before(stopping.cancels_before, mine=True)
        if stopping.obeyed_stop_turn is not None:
            self._set_still_running(goals.names_from_before(stopping.obeyed_stop_turn))
        is_reported = bool(motion.moving) and not motion.is_old(self._clock.monotonic())
        moves = bool(goals.running) or is_reported
        if stopping.must_cancel_others(moves=moves):
            self._thread().submit(self._cancel_others)
        elif stopping.cancels_others_before is not None:
            goals.cancel_from_before(stopping.cancels_others_before, mine=False)
        if stopping.must_repeat(moves=moves) and self._telemetry.is_robot_heard():
            self._thread().submit(stopping.send_again)

    async def _cancel_others(self) -> None:
        """Cancel every goal of the tracked actions, and report what came of it."""
        outcome = await self._goals.cancel_others()
        self._report(f"STOP is not confirmed: {outcome.text}", outcome.code)

    def _set_still_running(self, names: tuple[str, ...]) -> None:
        if names != self.still_running:
            self.still_running = names
            self._snapshots.send_soon()
