"""An event in a line. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from archo_tui.robot.state import Event, Hosted, logger_node


def event_text(event: Event) -> str:
    """`WARN dashboard: Low battery: 18.0% (x 12)`; the count is of all alike so far."""
    count = f" (x {event.count})" if event.count > 1 else ""
    return f"{event.level} {event.source}: {event.text}{count}"


def is_of_own_file(event: Event, hosted: Iterable[Hosted]) -> bool:
    """Return True for what a node of the user's own file logs or prints.

    Args:
        event: Its source is a logger's name (`lamp`, `lamp.motor`), or a node's and ` stdout`.
        hosted: The nodes of this process.
    """
    source = event.source.removesuffix(" stdout")
    node = logger_node(source)
    return any(
        f"{node}/".startswith(f"{own.name}/") or own.file == f"{source}.py"  # while it is imported
        for own in hosted
        if own.file
    )
