"""Actions as such, and the description that a launch file returns."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from archo_tui.launch.stand_ins.conditions import Condition
from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.places import calling_place


class LaunchDescriptionEntity:
    """The base of what a launch description is made of.

    Attributes:
        declares_argument: True for an argument of the launch file.
        resets_arguments: True if no argument that follows can be given.
        is_conditional: True if it is not known before the evaluation whether it is performed.
    """

    declares_argument = resets_arguments = is_conditional = False

    def __init__(self) -> None:
        self.place = calling_place()

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        """Do what the entity is for, and return the entities that come of it."""
        raise NotImplementedError

    def sub_entities(self) -> Iterable[Any]:
        """Return the entities that are known before the evaluation."""
        return ()

    def given_names(self) -> set[str]:
        """Return the names of the arguments that it gives to its sub-entities."""
        return set()


class Action(LaunchDescriptionEntity):
    """The base of all actions."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        super().__init__()
        self.condition = condition
        self.is_conditional = condition is not None

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        """Do what the action is for, and return the entities that come of it."""
        raise NotImplementedError


class LaunchDescription(LaunchDescriptionEntity):
    """The result of `generate_launch_description()`."""

    def __init__(
        self, initial_entities: Iterable[Any] | None = None, *, deprecated_reason: str | None = None
    ) -> None:
        super().__init__()
        self.entities = list(initial_entities or ())
        self._deprecated_reason = deprecated_reason

    def add_action(self, action: Any) -> None:
        """Add an action."""
        self.entities.append(action)

    add_entity = add_action

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self._deprecated_reason is not None:
            context.note(self.place, f"deprecated: {self._deprecated_reason}")
        return self.entities

    def sub_entities(self) -> Iterable[Any]:
        return self.entities
