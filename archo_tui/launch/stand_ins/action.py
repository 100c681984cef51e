"""The base of actions, and the description that a launch file returns."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from archo_tui.launch.stand_ins.conditions import Condition
from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.places import calling_place


class LaunchDescriptionEntity:
    """The base of everything that a launch description contains."""

    declares_argument = resets_arguments = is_conditional = False

    def __init__(self) -> None:
        self.place = calling_place()

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the entity, and return the entities to perform next; None for none."""
        raise NotImplementedError

    def sub_entities(self) -> Iterable[Any]:
        """Return the contained entities that are known before the evaluation; by default none."""
        return ()

    def given_names(self) -> set[str]:
        """Return the names of the arguments that this entity gives to its sub-entities."""
        return set()


class Action(LaunchDescriptionEntity):
    """The base of all actions, which are performed only if their condition holds."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        super().__init__()
        self.condition = condition
        self.is_conditional = condition is not None

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the action, and return the entities to perform next; None for none."""
        raise NotImplementedError


class LaunchDescription(LaunchDescriptionEntity):
    """The entities that `generate_launch_description()` returns."""

    def __init__(
        self, initial_entities: Iterable[Any] | None = None, *, deprecated_reason: str | None = None
    ) -> None:
        super().__init__()
        self.entities = list(initial_entities or ())
        self._deprecated_reason = deprecated_reason

    def add_action(self, action: Any) -> None:
        self.entities.append(action)

    add_entity = add_action

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self._deprecated_reason is not None:
            context.note(self.place, f"deprecated: {self._deprecated_reason}")
        return self.entities

    def sub_entities(self) -> Iterable[Any]:
        return self.entities
