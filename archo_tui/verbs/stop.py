"""The verbs for STOP and its release."""

from __future__ import annotations

from collections.abc import Iterator

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Latch
from archo_tui.robot_file.model import RobotFile, StopServices
from archo_tui.station.station import Station
from archo_tui.verbs.verb import Forms, Question, Values, Verb


class StopNow(Verb):
    """The verb `stop`: send the robot's STOP, or cancel every goal of a robot that has none."""

    id, title = "stop", "STOP"
    help = "STOP: software stop, holds until released; does not replace the hardware stop"
    acts = True
    timeout_help = ""

    @classmethod
    def of_robot(cls, robot: RobotFile, _forms: Forms) -> Iterator[Verb]:
        yield cls(robot.stop)

    def __init__(self, stop: StopServices | None) -> None:
        self.service = "" if stop is None else stop.service
        self.request = {} if stop is None else stop.request
        if stop is None:
            self.help = "Cancel every goal at once; the robot has no STOP: use the hardware stop"

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.emergency_stop()


class ReleaseStop(Verb):
    """The verb `release`: call the service that allows moves again after a STOP; it always asks.

    If every node that held the STOP has ended and no node offers the release, nothing is called,
    and the STOP is forgotten.
    """

    id, title = "release", "Release"
    help = "Release the stop (asks first); no goal resumes by itself"
    acts = may_ask = True

    @classmethod
    def of_robot(cls, robot: RobotFile, _forms: Forms) -> Iterator[Verb]:
        yield cls(robot.stop)

    def __init__(self, stop: StopServices | None) -> None:
        self.service = "" if stop is None else stop.release
        self.request = {} if stop is None else stop.release_request

    def disabled_reason(self, station: Station) -> str:
        snapshot = station.robot.snapshot
        if not self.service:
            return f"{snapshot.file.name} has no service to release a stop"
        released = snapshot.motion.stopped is False  # None if the robot does not report it.
        asked = snapshot.open_stop is not None or not station.robot.stops.are_answered
        released = released and not asked and snapshot.latch is Latch.NONE
        unavailable = "" if snapshot.stop_held_by_nobody else super().disabled_reason(station)
        return unavailable or ("the robot is not stopped" if released else "")

    def is_found(self, station: Station, values: Values) -> bool:
        """Return True once the robot has reported whether it is stopped, if it does report it."""
        snapshot, described = station.robot.snapshot, station.robot.file.motion
        is_awaited = described is not None and described.reports_stop
        return not is_awaited or snapshot.motion.stopped is not None or snapshot.stop_held_by_nobody

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.release()

    def question(self, station: Station, values: Values) -> Question:
        text = "Release the stop? Moves are allowed again; nothing resumes by itself."
        if station.robot.snapshot.stop_held_by_nobody:
            text = "Every node that held the stop has ended here. Forget the stop?"
            if station.robot.snapshot.open_stop is not None:
                text = "No node has got the STOP, since none serves it. Forget it?"
        return Question("Release", text, "Stay stopped", "Release")


class GiveUpStop(Verb):
    id, title = "give_up_stop", "Give up STOP"
    help = "Give up a STOP that the robot does not confirm, and send it no more (asks first)"
    acts = may_ask = True

    def disabled_reason(self, station: Station) -> str:
        stop = station.robot.snapshot.open_stop
        return "" if stop is not None else "no STOP is waiting to be confirmed"

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.give_up_stop()

    def question(self, station: Station, values: Values) -> Question:
        text = "The robot has not confirmed the STOP and may be driving. Send it no more?"
        return Question("Give up STOP", text, "Keep sending", "Give up")
