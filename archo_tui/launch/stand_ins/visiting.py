"""The walk through a launch description, in the order in which launch performs it."""

from __future__ import annotations

import heapq
import reprlib
from typing import Any

from archo_tui.launch.stand_ins.action import LaunchDescriptionEntity
from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.failures import SkipActionError, SubstitutionFailure
from archo_tui.launch.stand_ins.places import Place


def visit(entity: Any, context: LaunchContext, within: Place) -> None:
    """Perform an entity, then those that it returns; leave out what is not supported."""
    if not isinstance(entity, LaunchDescriptionEntity):
        text = f"an action is wanted, not a {type(entity).__name__}: {reprlib.repr(entity)}"
        raise SubstitutionFailure(text, within)
    try:
        found = entity.visit(context)
    except SkipActionError as error:
        is_elsewhere = error.is_value and error.place != entity.place
        needed_by = f" (line {entity.place.line})" if is_elsewhere else ""
        context.note(error.place, f"{error}{needed_by}")
        return
    except Exception:
        context.failed_at = entity.place
        raise
    for part in found or ():
        visit(part, context, entity.place)


def visit_delayed(context: LaunchContext) -> None:
    """Perform the actions of timers in the order of their times, without waiting."""
    while context.delayed:
        delayed = heapq.heappop(context.delayed)
        context.time = delayed.time
        vars(context.locals).update(delayed.local_values)
        for action in delayed.actions:
            visit(action, context, Place("", 0))
