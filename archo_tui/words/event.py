"""An event in a line. Pure."""

from __future__ import annotations

from archo_tui.robot.state import Event


def event_text(event: Event) -> str:
    """`WARN dashboard: Low battery: 18.0% (x 12)`; the count is of all alike so far."""
    count = f" (x {event.count})" if event.count > 1 else ""
    return f"{event.level} {event.source}: {event.text}{count}"
