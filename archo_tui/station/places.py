"""The places of a robot and lists of goals, each under a name: of its file, and of the user."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.base.paths import make_folder
from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.base.yaml_text.dump import block
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot_file.load import plain, read_node
from archo_tui.robot_file.model import GoalKind, Place, RobotFile, is_place_name
from archo_tui.station.save_load import write_atomically

FILE = "places.yaml"  # In the folder of settings.


@dataclass(frozen=True)
class SavedGoal:
    """A goal in the user's file."""

    goal: str  # Its id.
    values: Mapping[str, Any]  # By dotted path.


def _names(given: Iterable[str]) -> str:
    odd = next((name for name in given if not is_place_name(name)), None)
    return (
        "" if odd is None else f"has {odd!r}, which is no name: a letter, then letters and digits"
    )


@dataclass(frozen=True)
class SavedNames:
    """The places and lists of one robot in the user's file, by names."""

    places: Annotated[Mapping[str, SavedGoal], "one goal each", _names] = field(
        default_factory=dict
    )
    lists: Annotated[Mapping[str, tuple[SavedGoal, ...]], "several goals each", _names] = field(
        default_factory=dict
    )


class Places:
    """All places and lists of one robot. `load` and `save_...` use a file, and block."""

    def __init__(self, robot: RobotFile, path: Path | None = None) -> None:
        self._robot, self.path = robot, path
        self._kinds = {kind.id: kind for kind in robot.goals}
        first = robot.goals[0].id if robot.goals else ""
        self._given = [replace(place, goal=place.goal or first) for place in robot.places]
        self._own = SavedNames()
        self.fault = ""  # Why the user's file is not read.

    @property
    def all(self) -> list[Place]:
        """All places by name; of two with one name that of the robot file."""
        given = {place.name for place in self._given}
        own = self._own.places.items()
        more = [Place(name, of.values, of.goal) for name, of in own if name not in given]
        return [*self._given, *more]

    @property
    def lists(self) -> Mapping[str, Sequence[SavedGoal]]:
        """The lists of goals by name."""
        return self._own.lists

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
        for saved in self.lists[name]:
            if saved.goal not in self._kinds or not self._fits(saved):
                raise ArchoError(
                    f"{name}: the robot file has no goal {saved.goal} with these fields"
                )
            found.append(QueuedGoal(self._kinds[saved.goal], saved.values))
        if not found:
            raise ArchoError(f"{name} has no goals")
        return found

    def _fits(self, saved: SavedGoal) -> bool:
        kind = self._kinds.get(saved.goal)
        return kind is None or saved.values.keys() == kind.form.keys()

    def save_place(self, name: str, kind: GoalKind, values: Mapping[str, Any]) -> None:
        """Add a place of the user's own, or replace one, and write the file; ArchoError."""
        self._check_name(name)
        own = self._read_own()  # Another console may have written it.
        place = SavedGoal(kind.id, dict(values))
        self._write(replace(own, places={**own.places, name: place}))

    def save_list(self, name: str, goals: Sequence[QueuedGoal]) -> None:
        """Add a list of goals, or replace one, and write the file; ArchoError."""
        self._check_name(name)
        own = self._read_own()
        saved = tuple(SavedGoal(goal.kind.id, dict(goal.values)) for goal in goals)
        self._write(replace(own, lists={**own.lists, name: saved}))

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
        self._own = self._read_own()

    def _read_own(self) -> SavedNames:
        own: SavedNames = self._read().get(self._robot.name, SavedNames())
        for saved in (
            *own.places.values(),
            *(goal for goals in own.lists.values() for goal in goals),
        ):
            if not self._fits(saved):
                raise ArchoError(f"{self.path}: goal {saved.goal} has other fields")
        return own

    def _read(self) -> dict[str, Any]:
        """Return this robot's part of the user's file as SavedNames, and the others as they are."""
        if self.path is None:
            return {}
        try:
            node = bounded_yaml.compose(bounded_yaml.read(self.path), self.path)
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise ArchoError(f"{self.path}: not read: {error}") from None
        if node is None:
            return {}
        robots = dict(read_node(Mapping[str, Any], node, self.path))
        for key, part in node.value:
            if key.value == self._robot.name:
                robots[key.value] = read_node(SavedNames, part, self.path)
        return robots

    def _write(self, own: SavedNames) -> None:
        """Write the user's file, other robots' parts of it as they are, and take it; ArchoError."""
        if self.path is None:
            raise ArchoError("there is no folder for settings")
        robots = {**self._read(), self._robot.name: own}
        try:
            make_folder(self.path)
        except OSError as error:
            raise ArchoError(f"{self.path.parent}: {error.strerror}") from None
        write_atomically(self.path, block(plain(robots)))
        self._own = own
