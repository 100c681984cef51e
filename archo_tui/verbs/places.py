"""The verbs for places and for lists of goals, each under a name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.goal import values_text
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.station.goal_driver import MAX_QUEUED_GOALS
from archo_tui.station.station import Station
from archo_tui.verbs.goals import GOALS, Go, GoalVerb
from archo_tui.verbs.verb import Argument, Forms, NotPossible, Values, Verb


class _PlaceVerb(Verb):
    """The base of these verbs, which a robot with goals has."""

    def __init__(self, goals: Sequence[Go]) -> None:
        self._goals = goals

    @classmethod
    def of_robot(cls, robot: RobotFile, forms: Forms) -> Iterator[Verb]:
        if robot.goals:
            yield cls([*Go.of_robot(robot, forms)])


class ShowPlaces(_PlaceVerb):
    id, title, tells = "places", "Places", True
    help = "List the places and the lists of goals"

    async def run(self, station: Station, values: Values) -> Outcome:
        await in_daemon(station.places.read_again)
        places, kinds = station.places, {kind.id: kind for kind in station.robot.file.goals}
        lines: list[str] = []
        data: list[dict[str, Any]] = []
        for place in places.all:
            text = values_text(kinds[place.goal], place.values) if place.goal in kinds else "?"
            lines.append(f"{place.name}: {place.goal} {text}")
            data.append({"name": place.name, "goal": place.goal, "values": dict(place.values)})
        for name, goals in places.lists.items():
            lines.append(f"{name}: a list of {len(goals)} goals")
            data.append({"name": name, "goals": len(goals)})
        return Report.of("\n".join(lines) or "no place has a name yet: save_place NAME", data)


class SavePlace(_PlaceVerb):
    """The verb `save_place`: give a goal's values, or the robot's pose, a name."""

    id, title = "save_place", "Save a place"
    help = "Save where the robot is, or a goal, as a place with a name"
    arguments = (Argument("name"), Argument("value", many=True, optional=True))

    @property
    def pose_goal(self) -> Go | None:
        """The goal that leads to where the robot is; None if none of the robot's is a pose."""
        return next((go for go in self._goals if is_pose(go.kind)), None)

    async def prepare(self, station: Station, values: Values) -> Values:
        first = self._goals[0]
        if not values["value"]:
            go = self.pose_goal or first
            return {**values, GOALS: [self._pose(station, go.kind)], "go": go}
        prepared = await first.prepare(station, first.values(values["value"]))
        if len(prepared[GOALS]) != 1:
            raise ValueError("a place is one goal; save_queue saves several")
        return {**values, **prepared, "go": first}

    def _pose(self, station: Station, kind: GoalKind) -> dict[str, Any]:
        """Return the goal that leads to where the robot is; NotPossible if that is not known."""
        pose = station.robot.snapshot.pose
        if pose.x is None or pose.y is None or pose.is_old(station.clock.monotonic()):
            raise NotPossible(f"the pose is not known: type the values, {self.id} NAME VALUE ...")
        frame = next((v for path, v in kind.fixed.items() if path.endswith("frame_id")), "")
        if frame and pose.frame and frame != pose.frame:
            raise NotPossible(f"the pose is in {pose.frame}, and the goal in {frame}")
        return pose_goal(kind, {"x": pose.x, "y": pose.y, "yaw": pose.yaw or 0.0})

    async def run(self, station: Station, values: Values) -> Outcome:
        go, name, goal = values["go"], values["name"], values[GOALS][0]
        kind = go.kind
        await in_daemon(station.places.save_place, name, kind, goal)
        text = f"{name} is {values_text(kind, goal)}: {go.id} {name} drives there"
        station.robot.note("YOU", "console", f"place {name}: saved as {values_text(kind, goal)}")
        return Outcome(Code.DONE, text)


def is_pose(kind: GoalKind) -> bool:
    """Return True if a goal's form has `x`, `y` and `yaw` only."""
    with suppress(NotPossible):
        return bool(pose_goal(kind, dict.fromkeys(("x", "y", "yaw"), 0.0)))
    return False


def pose_goal(kind: GoalKind, pose: Mapping[str, float]) -> dict[str, Any]:
    """Return the values of a goal whose form is `x`, `y` and `yaw`; NotPossible for another."""
    found: dict[str, Any] = {}
    for path, field in kind.form.items():
        name = "yaw" if field.convert == "yaw" else path.rpartition(".")[2]
        if name not in pose:
            raise NotPossible(f"{kind.title}: {field.label or path} is no part of a pose")
        found[path] = round(pose[name], 3)
    if not found:
        raise NotPossible(f"{kind.title} leads to no pose")
    return found


class SaveQueue(_PlaceVerb):
    id, title = "save_queue", "Save the queue"
    help = "Save the running goal and the queue as a list with a name"
    arguments = (Argument("name"),)

    def disabled_reason(self, station: Station) -> str:
        return "" if self._present(station) else "no goal runs or waits"

    @staticmethod
    def _present(station: Station) -> list[QueuedGoal]:
        """Return the running goal, if it is ours, and those behind it."""
        running, kinds = station.running_goal, station.robot.file.goals
        first = [] if running is None or not running.mine else [running]
        goals = [QueuedGoal(goal.kind, goal.fields) for goal in first]
        return [goal for goal in (*goals, *station.queue.waiting) if goal.kind in kinds]

    async def run(self, station: Station, values: Values) -> Outcome:
        goals = self._present(station)
        await in_daemon(station.places.save_list, values["name"], goals)
        shown = ", ".join(goal.text for goal in goals)
        station.robot.note("YOU", "console", f"list {values['name']}: saved as {shown}")
        text = f"{values['name']} is {shown}: go_list {values['name']} drives to them"
        return Outcome(Code.DONE, text)


class Drive(GoalVerb, _PlaceVerb):
    """The verb `go_list`: send the goals of a list, once or several times in turn."""

    id, title = "go_list", "Go to the goals of a list"
    help = "Send the goals of a list, once or N times in turn"
    arguments = (
        Argument("name", completer=lambda station, _: station.places.lists),
        Argument("n", optional=True),
    )

    async def prepare(self, station: Station, values: Values) -> Values:
        text = values.get("n", "1")
        if not (text.isascii() and text.isdecimal() and 1 <= int(text[:9]) <= MAX_QUEUED_GOALS):
            raise ValueError(f"how often: from 1 to {MAX_QUEUED_GOALS}, not {text}")
        await in_daemon(station.places.read_again)
        by_id, checked = {go.kind.id: go for go in self._goals}, []
        for goal in station.places.goals(values["name"]):
            go = by_id[goal.kind.id]
            given = await go.prepare(station, {GOALS: [go.parsed(goal.values)]})
            checked.append(goal._replace(values=given[GOALS][0]))
        return {**values, GOALS: checked * int(text)}

    def queued(self, values: Values) -> list[QueuedGoal]:
        return list(values[GOALS])
