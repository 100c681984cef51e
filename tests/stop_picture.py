"""The table and the picture of STOP's states for docs/stop.md, from the machine itself."""

from __future__ import annotations

import re
from pathlib import Path

from archo_tui.robot.stop import machine
from archo_tui.robot.stop.machine import LATCH, Event, State

_PLACES = {  # The middle of each box.
    State.NONE: (130, 60),
    State.HELD: (670, 60),
    State.UNCERTAIN: (670, 330),
    State.DOUBTED: (130, 330),
}
_WIDTH, _HEIGHT = 150, 44
# Where each arrow bends to.
_BENDS = {
    (State.NONE, State.HELD): (400, 30),
    (State.HELD, State.NONE): (400, 100),
    (State.HELD, State.UNCERTAIN): (775, 175),
    (State.UNCERTAIN, State.HELD): (590, 215),
    (State.UNCERTAIN, State.DOUBTED): (400, 375),
    (State.NONE, State.DOUBTED): (55, 175),
    (State.DOUBTED, State.NONE): (185, 240),
    (State.HELD, State.DOUBTED): (540, 270),
    (State.DOUBTED, State.HELD): (330, 140),
    (State.UNCERTAIN, State.NONE): (220, 300),
}


def table() -> str:
    """LATCH, a row an event."""
    source = Path(machine.__file__).read_text(encoding="utf-8")
    said = dict(re.findall(r"^    (\w+) = auto\(\)  # (.*)$", source, re.M))
    heads = " | ".join(state.name for state in State)
    rows = [f"| event | what has happened | {heads} |", f"|---|---|{'---|' * len(State)}"]
    for event, states in LATCH.items():
        cells = [
            "-" if to is None else "" if to is before else to.name
            for before, to in zip(State, states, strict=True)
        ]
        rows.append(f"| `{event.name}` | {said[event.name]} | {' | '.join(cells)} |")
    return "\n".join((*rows, ""))


def steps() -> dict[tuple[State, State], list[Event]]:
    """The events that lead from one state to another one."""
    found: dict[tuple[State, State], list[Event]] = {}
    for event, states in LATCH.items():
        for before, to in zip(State, states, strict=True):
            if to is not None and before is not to:
                found.setdefault((before, to), []).append(event)
    return found


def picture() -> str:
    """The states and steps as an SVG."""
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 860 400" font-family="sans-serif">',
        '<defs><marker id="end" markerWidth="9" markerHeight="9" refX="8" refY="4" orient="auto">',
        '<path d="M0,0 L9,4 L0,8 z" fill="#555"/></marker></defs>',
        '<rect width="860" height="400" fill="#fff"/>',
    ]
    for before, to in sorted(steps(), key=str):
        (x1, y1), (x, y), (x2, y2) = _arrow(before, to)
        lines.append(
            f'<path d="M{x1},{y1} Q{x},{y} {x2},{y2}" fill="none" stroke="#777" '
            'marker-end="url(#end)"/>'
        )
    for (before, to), events in sorted(steps().items(), key=lambda step: str(step[0])):
        (x1, y1), (x, y), (x2, y2) = _arrow(before, to)
        x, y = (x1 + 2 * x + x2) // 4, (y1 + 2 * y + y2) // 4  # The middle of the curve.
        for row, event in enumerate(events):
            top = y + 12 * row - 6 * len(events) + 8
            lines.append(
                f'<text x="{x}" y="{top}" font-size="10" text-anchor="middle" fill="#222" '
                f'stroke="#fff" stroke-width="3" paint-order="stroke">{event.name}</text>'
            )
    for state, (x, y) in _PLACES.items():
        left, top = x - _WIDTH // 2, y - _HEIGHT // 2
        lines.append(
            f'<rect x="{left}" y="{top}" width="{_WIDTH}" height="{_HEIGHT}" rx="8" '
            'fill="#eef3fa" stroke="#356"/>'
        )
        lines.append(
            f'<text x="{x}" y="{y + 5}" font-size="15" text-anchor="middle">{state.name}</text>'
        )
    return "\n".join((*lines, "</svg>", ""))


def _arrow(before: State, to: State) -> tuple[tuple[int, int], ...]:
    """Return where an arrow begins, bends to, and ends."""
    bend = _BENDS[before, to]
    return _edge(*_PLACES[before], *bend), bend, _edge(*_PLACES[to], *bend)


def _edge(x: int, y: int, towards_x: int, towards_y: int) -> tuple[int, int]:
    """Return the point of a box's edge on the line from its middle to a point."""
    dx, dy = towards_x - x, towards_y - y
    scale = min(
        _WIDTH / 2 / abs(dx) if dx else float("inf"), _HEIGHT / 2 / abs(dy) if dy else float("inf")
    )
    return round(x + dx * scale), round(y + dy * scale)
