"""The arguments of a launch file, as far as they are known before its evaluation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from archo_tui.launch.stand_ins.action import LaunchDescriptionEntity


class DeclaredArgument(NamedTuple):
    """An argument that a launch file, or one that it includes, declares."""

    argument: Any  # The DeclareLaunchArgument.
    is_conditional: bool  # A condition or a timer decides whether it is declared.
    given: frozenset[str]  # By the includes around it.

    @property
    def is_required(self) -> bool:
        """True if a value must be given: there is no default, and no condition decides."""
        return self.argument.default_value is None and not self.is_conditional


def declared_arguments(entities: Iterable[Any]) -> list[DeclaredArgument]:
    """Return the arguments that entities declare; of several of a name, the first.

    Included files whose paths are known are loaded, which runs the code in them; one that fails
    counts as empty.
    """
    found: dict[str, DeclaredArgument] = {}
    for declared in _walk(entities, False, frozenset()):
        found.setdefault(declared.argument.name, declared)
    return list(found.values())


def _walk(
    entities: Iterable[Any], is_conditional: bool, given: frozenset[str]
) -> Iterator[DeclaredArgument]:
    for entity in entities:
        if not isinstance(entity, LaunchDescriptionEntity):
            continue  # The evaluation will tell.
        if entity.resets_arguments:
            return  # What is declared after it cannot be given any more.
        conditional = is_conditional or entity.is_conditional
        if entity.declares_argument:
            yield DeclaredArgument(entity, conditional, given)
        yield from _walk(entity.sub_entities(), conditional, given | entity.given_names())
