"""The texts of an event. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.events import LAUNCH, Event
from archo_tui.robot.state.graph import logger_node
from archo_tui.robot.state.snapshot import Hosted

_GRAVITY = {"WARN": "▲", "ERROR": "✗", "FATAL": "✗"}
_INDENT = " " * len("12:04:31 ")
_OPEN = (Code.HELD, Code.TIMEOUT, Code.NOT_CONFIRMED)  # It may still be done.


def event_text(event: Event) -> str:
    """Return an event as text, such as `WARN dashboard: Low battery: 18.0% (x 12)`.

    The further lines of a log line are indented: none looks like a line of the console.
    """
    count = f" (x {event.count})" if event.count > 1 else ""
    text = event.text.replace("\n", f"\n{_INDENT}")
    return f"{event.level} {event.source}: {text}{count}"


def one_line_text(event: Event) -> str:
    """Return the text of an event with a blank for each line feed of a log line."""
    return event.text.replace("\n", " ")


def outcome_glyph(event: Event) -> str:
    """Return `✓` for done, `✗` failed or an error, `▲` open or a warning, `·` anything else."""
    if event.level in _GRAVITY:
        return _GRAVITY[event.level]
    if event.code in ("", Code.ACCEPTED):  # The end of a goal is an event of its own.
        return "·"
    if event.code in (Code.DONE, Code.ARRIVED):
        return "✓"
    return "▲" if event.code in _OPEN else "✗"


def is_of_own_file(event: Event, hosted: Iterable[Hosted]) -> bool:
    """Return True if the user's own file, or a launch file, logged or printed the event."""
    if event.source == LAUNCH:
        return True
    source = event.source.removesuffix(" stdout")
    node = logger_node(source)
    return any(
        f"{node}/".startswith(f"{own.name}/")
        or own.file == f"{source}.py"  # Printed during its import.
        for own in hosted
        if own.file
    )
