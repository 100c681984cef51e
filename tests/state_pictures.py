"""The tables and pictures of STOP's and a goal's states for docs/stop.md, from the machines."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import Any

from archo_tui.robot.goals import machine as goals
from archo_tui.robot.state.goal import RUNNING, Phase
from archo_tui.robot.stop import machine as stop

_MOVING, _UNKNOWN, _LOST = Phase.MOVING, Phase.UNKNOWN, Phase.LOST


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
    """The states of a STOP, as Mermaid draws them."""
    found: dict[tuple[str, str], list[str]] = {}
    for event, states in stop.LATCH.items():
        for before, to in zip(stop.State, states, strict=True):
            if to is not None and before is not to:
                found.setdefault((before.name, to.name), []).append(event.name)
    return _mermaid(found)


def goal_picture() -> str:
    """The phases of a goal, as Mermaid draws them; all ends are one."""
    found: dict[tuple[str, str], list[str]] = {}
    for event, phases in goals.PHASES.items():
        for before, to in zip(RUNNING, phases, strict=True):
            for after in [_MOVING, _UNKNOWN, _LOST] if to is None else [to]:
                if before is not after:
                    end = after.name if after in RUNNING else "[*]"
                    found.setdefault((before.name, end), []).append(event.name)
    always = {event.name for event, phases in goals.PHASES.items() if phases[0] not in RUNNING}
    always -= {goals.Event.REFUSED.name}
    for step, names in found.items():
        if step[1] == "[*]":
            found[step] = [*(name for name in names if name not in always), "its end"]
    return _mermaid(found)


def _mermaid(steps: Mapping[tuple[str, str], Sequence[str]]) -> str:
    rows = [f"    {a} --> {b}: {', '.join(names)}" for (a, b), names in sorted(steps.items())]
    return "\n".join(("```mermaid", "stateDiagram-v2", *rows, "```", ""))
