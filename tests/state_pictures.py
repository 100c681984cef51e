"""The tables and pictures of STOP's and a goal's states for docs/stop.md, from the machines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from archo_tui.robot.goals import machine as goals
from archo_tui.robot.state.goal import RUNNING, Phase
from archo_tui.robot.stop import machine as stop

_N, _H, _U, _D = stop.State
_S, _M, _C, _UNKNOWN, _L = RUNNING
ENDED = "ENDED"
_WIDTH, _HEIGHT = 150, 44


class _Picture(NamedTuple):
    """Where boxes and arrows are."""

    size: tuple[int, int]
    places: Mapping[Any, tuple[int, int]]  # The middle of each box.
    bends: Mapping[tuple[Any, Any], tuple[int, int]]  # Where each arrow bends to.


_STOP = _Picture(
    (860, 400),
    {_N: (130, 60), _H: (670, 60), _U: (670, 330), _D: (130, 330)},
    {
        (_N, _H): (400, 30),
        (_H, _N): (400, 100),
        (_H, _U): (775, 175),
        (_U, _H): (590, 215),
        (_U, _D): (400, 375),
        (_N, _D): (55, 175),
        (_D, _N): (185, 240),
        (_H, _D): (540, 270),
        (_D, _H): (330, 140),
        (_U, _N): (220, 300),
    },
)
_GOAL = _Picture(
    (900, 520),
    {
        _S: (110, 80),
        _M: (450, 80),
        _C: (790, 80),
        _UNKNOWN: (110, 400),
        _L: (450, 400),
        ENDED: (790, 400),
    },
    {
        (_S, _M): (280, 55),
        (_S, _UNKNOWN): (60, 240),
        (_S, ENDED): (300, 190),
        (_M, _C): (620, 45),
        (_M, _L): (405, 240),
        (_M, ENDED): (590, 250),
        (_C, _M): (620, 115),
        (_C, _L): (560, 330),
        (_C, _UNKNOWN): (330, 300),
        (_C, ENDED): (850, 240),
        (_UNKNOWN, _M): (215, 250),
        (_UNKNOWN, _C): (520, 200),
        (_UNKNOWN, ENDED): (450, 490),
        (_L, _M): (500, 340),
        (_L, _C): (690, 250),
        (_L, _UNKNOWN): (280, 420),
        (_L, ENDED): (620, 425),
    },
)


def stop_table() -> str:
    """LATCH, a row an event."""
    return _table(stop, stop.LATCH, [*stop.State])


def goal_table() -> str:
    """PHASES, a row an event."""
    table = {
        event: [before if to is None else to for before, to in zip(RUNNING, phases, strict=True)]
        for event, phases in goals.PHASES.items()
    }
    # A cancel that failed returns to the phase before it; nothing else is not a phase.
    text = _table(goals, table, [*RUNNING])
    row = next(line for line in text.splitlines() if line.startswith("| `CANCEL_FAILED`"))
    cells = row.split("|")
    cells[3 + RUNNING.index(Phase.CANCELLING)] = " the phase before "
    return text.replace(row, "|".join(cells))


def _table(machine: ModuleType, table: Mapping[Any, Sequence[Any]], states: Sequence[Enum]) -> str:
    source = Path(str(machine.__file__)).read_text(encoding="utf-8")
    events = source.partition("class Event(")[2].partition("class ")[0]
    said = dict(re.findall(r"^    (\w+) = auto\(\)  # (.*)$", events, re.M))
    heads = " | ".join(state.name for state in states)
    rows = [f"| event | what has happened | {heads} |", f"|---|---|{'---|' * len(states)}"]
    for event, afters in table.items():
        cells = [
            "-" if to is None else "" if to is before else to.name
            for before, to in zip(states, afters, strict=True)
        ]
        rows.append(f"| `{event.name}` | {said[event.name]} | {' | '.join(cells)} |")
    return "\n".join((*rows, ""))


def stop_picture() -> str:
    """The states of a STOP as an SVG."""
    found: dict[tuple[Any, Any], list[str]] = {}
    for event, states in stop.LATCH.items():
        for before, to in zip(stop.State, states, strict=True):
            if to is not None and before is not to:
                found.setdefault((before, to), []).append(event.name)
    return _svg(_STOP, found)


def goal_picture() -> str:
    """The phases of a goal as an SVG; all ends are one box."""
    found: dict[tuple[Any, Any], list[str]] = {}
    for event, phases in goals.PHASES.items():
        for before, to in zip(RUNNING, phases, strict=True):
            afters = [_M, _UNKNOWN, _L] if to is None else [to if to in RUNNING else ENDED]
            for after in afters:
                if before is not after:
                    found.setdefault((before, after), []).append(event.name)
    always = {event.name for event, phases in goals.PHASES.items() if phases[0] not in RUNNING}
    always -= {goals.Event.REFUSED.name}
    for step, names in found.items():
        if step[1] == ENDED:
            left = [name for name in names if name not in always]
            found[step] = [*left, "its end"]
    return _svg(_GOAL, found)


def _svg(picture: _Picture, steps: Mapping[tuple[Any, Any], Iterable[str]]) -> str:
    width, height = picture.size
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif">',
        '<defs><marker id="end" markerWidth="9" markerHeight="9" refX="8" refY="4" orient="auto">',
        '<path d="M0,0 L9,4 L0,8 z" fill="#555"/></marker></defs>',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    in_order = sorted(steps.items(), key=lambda step: str(step[0]))
    for (before, to), _ in in_order:
        (x1, y1), (x, y), (x2, y2) = _arrow(picture, before, to)
        lines.append(
            f'<path d="M{x1},{y1} Q{x},{y} {x2},{y2}" fill="none" stroke="#777" '
            'marker-end="url(#end)"/>'
        )
    for (before, to), names in in_order:
        (x1, y1), (x, y), (x2, y2) = _arrow(picture, before, to)
        x, y = (x1 + 2 * x + x2) // 4, (y1 + 2 * y + y2) // 4  # The middle of the curve.
        rows = [*names]
        for row, name in enumerate(rows):
            top = y + 12 * row - 6 * len(rows) + 8
            lines.append(
                f'<text x="{x}" y="{top}" font-size="10" text-anchor="middle" fill="#222" '
                f'stroke="#fff" stroke-width="3" paint-order="stroke">{name}</text>'
            )
    for state, (x, y) in picture.places.items():
        left, top = x - _WIDTH // 2, y - _HEIGHT // 2
        lines.append(
            f'<rect x="{left}" y="{top}" width="{_WIDTH}" height="{_HEIGHT}" rx="8" '
            'fill="#eef3fa" stroke="#356"/>'
        )
        name = state if isinstance(state, str) else state.name
        lines.append(f'<text x="{x}" y="{y + 5}" font-size="15" text-anchor="middle">{name}</text>')
    return "\n".join((*lines, "</svg>", ""))


def _arrow(picture: _Picture, before: Any, to: Any) -> tuple[tuple[int, int], ...]:
    """Return where an arrow begins, bends to, and ends."""
    bend = picture.bends[before, to]
    return _edge(*picture.places[before], *bend), bend, _edge(*picture.places[to], *bend)


def _edge(x: int, y: int, towards_x: int, towards_y: int) -> tuple[int, int]:
    """Return the point of a box's edge on the line from its middle to a point."""
    dx, dy = towards_x - x, towards_y - y
    scale = min(
        _WIDTH / 2 / abs(dx) if dx else float("inf"), _HEIGHT / 2 / abs(dy) if dy else float("inf")
    )
    return round(x + dx * scale), round(y + dy * scale)
