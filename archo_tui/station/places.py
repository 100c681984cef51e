"""The places of a robot and lists of goals, each under a name: of its file, and of the user."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.nearest import nearest_hint
from archo_tui.parameters.save_load import write_atomically
from archo_tui.paths import make_folder
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot_file.model import GoalKind, Place, RobotFile, is_place_name
from archo_tui.yaml_text import bounded_yaml
from archo_tui.yaml_text.dump import block

FILE = "places.yaml"  # In the folder of settings.
_PLACES, _LISTS = "places", "lists"
_SHAPE = "expected robots with places and lists, as archo-tui writes them"


class Places:
    """All places and lists of one robot. `load` and `save_...` use a file, and block."""

    def __init__(self, robot: RobotFile, path: Path | None = None) -> None:
        """Create them; `path` is the user's file, None for none."""
        self._robot, self.path = robot, path
        self._kinds = {kind.id: kind for kind in robot.goals}
        first = robot.goals[0].id if robot.goals else ""
        self._given = [replace(place, goal=place.goal or first) for place in robot.places]
        self._own: dict[str, Place] = {}
        self.lists: dict[str, list[tuple[str, Mapping[str, Any]]]] = {}  # Goal ids and values.
        self.fault = ""  # Why the user's file is not read.

    @property
    def all(self) -> list[Place]:
        """All places by name; of two with one name that of the robot file."""
        given = {place.name for place in self._given}
        own = [place for place in self._own.values() if place.name not in given]
        return [*self._given, *own]

    def of(self, kind: GoalKind) -> dict[str, Mapping[str, Any]]:
        """Return the values of the places of a kind of goal, by name."""
        return {place.name: place.values for place in self.all if place.goal == kind.id}

    def find(self, kind: GoalKind, name: str) -> Mapping[str, Any]:
        """Return the values of a place, whose name must be spelled exactly; ArchoError."""
        known = self.of(kind)
        if name not in known:
            raise ArchoError(f"no place {name}{nearest_hint(name, known)}")
        return known[name]

    def goals(self, name: str) -> list[QueuedGoal]:
        """Return the goals of a list; ArchoError if there is none, or no such goal any more."""
        if name not in self.lists:
            raise ArchoError(f"no list {name}{nearest_hint(name, self.lists)}")
        found = []
        for goal, values in self.lists[name]:
            kind = self._kinds.get(goal)
            if kind is None or values.keys() != kind.form.keys():
                raise ArchoError(f"{name}: the robot file has no goal {goal} with these fields")
            found.append(QueuedGoal(kind, values))
        if not found:
            raise ArchoError(f"{name} has no goals")
        return found

    def save_place(self, name: str, kind: GoalKind, values: Mapping[str, Any]) -> None:
        """Add a place of the user's own, or replace one, and write the file; ArchoError."""
        self._check_name(name)
        self.read_again()  # Another console may have written it.
        place = Place(name, dict(values), kind.id)
        self._write({**self._own, name: place}, self.lists)

    def save_list(self, name: str, goals: Sequence[QueuedGoal]) -> None:
        """Add a list of goals, or replace one, and write the file; ArchoError."""
        self._check_name(name)
        self.read_again()
        made = [(goal.kind.id, dict(goal.values)) for goal in goals]
        self._write(self._own, {**self.lists, name: made})

    def _check_name(self, name: str) -> None:
        if not is_place_name(name):
            raise ArchoError(f"{name!r} is no name: a letter, then letters, digits, _ and -")
        if any(place.name == name for place in self._given):
            raise ArchoError(f"{name} is a place of the robot file: choose another name")

    def load(self) -> None:
        """Read the user's file, if there is one; `fault` says why it is not read."""
        try:
            self.read_again()
        except ArchoError as error:
            self.fault = str(error)

    def read_again(self) -> None:
        """Read the user's file, which another console may have written; ArchoError."""
        if self.path is not None:
            self._replace_all(self._read(self.path).get(self._robot.name))

    def _write(
        self, own: Mapping[str, Place], all_lists: Mapping[str, Sequence[tuple[str, Any]]]
    ) -> None:
        """Write the user's file, other robots' parts of it as they are, and take it; ArchoError."""
        if self.path is None:
            raise ArchoError("there is no folder for settings")
        robots = self._read(self.path)
        places = {
            name: {"goal": place.goal, "values": dict(place.values)} for name, place in own.items()
        }
        lists = {
            name: [{"goal": goal, "values": dict(values)} for goal, values in goals]
            for name, goals in all_lists.items()
        }
        robots[self._robot.name] = {_PLACES: places, _LISTS: lists}
        try:
            make_folder(self.path)
        except OSError as error:
            raise ArchoError(f"{self.path.parent}: {error.strerror}") from None
        write_atomically(self.path, block(robots))
        self._own, self.lists = dict(own), {name: list(goals) for name, goals in all_lists.items()}

    def _read(self, path: Path) -> dict[str, Any]:
        try:
            found = bounded_yaml.load(bounded_yaml.read(path))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise ArchoError(f"{path}: not read: {error}") from None
        if found is None:
            return {}
        if not isinstance(found, dict):
            raise ArchoError(f"{path}: {_SHAPE}")
        return found

    def _replace_all(self, part: Any) -> None:
        def goal_of(given: Any) -> tuple[str, dict[str, Any]]:
            goal, values = given["goal"], given["values"]
            if goal in self._kinds and values.keys() != self._kinds[goal].form.keys():
                raise KeyError
            return str(goal), dict(values)

        try:
            part = part or {}
            own = {name: goal_of(given) for name, given in part.get(_PLACES, {}).items()}
            lists: dict[str, list[tuple[str, Mapping[str, Any]]]] = {
                name: [*map(goal_of, given)] for name, given in part.get(_LISTS, {}).items()
            }
            if not all(is_place_name(name) for name in (*own, *lists)):
                raise ValueError
        except (KeyError, TypeError, AttributeError, ValueError):
            raise ArchoError(f"{self.path}: {_SHAPE}") from None
        self._own = {name: Place(name, values, goal) for name, (goal, values) in own.items()}
        self.lists = lists
