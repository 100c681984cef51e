"""The texts for a screen reader: no glyphs, columns or grouped digits. Pure functions."""

from __future__ import annotations

import re
from collections.abc import Sequence

from archo_tui.base.clock import time_of_day
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.text.goal import NO_ESTIMATE, goal_line, remaining_text
from archo_tui.text.state import (
    Spans,
    battery_line,
    battery_word,
    motion_age,
    motion_unit,
    motion_word,
    no_reading_reason,
    speed_text,
)

_GLYPHS = "●○✗✓▲▶↯? "  # Each stands before a word with the same meaning.
_WIDTH = 80  # Enough cells for any text in full.


def spans_to_text(spans: Spans) -> str:
    """Return `MOVING to 12, 9.0 m left of 18.0 m`, a comma for each gap."""
    parts = (part for text, _ in spans for part in re.split(" {2,}", text.strip()))
    return without_glyph(", ".join(filter(None, parts)))


def without_glyph(text: str) -> str:
    """Return a text without the glyphs and blanks that it begins with."""
    return text.lstrip(_GLYPHS)


def battery_text(snapshot: Snapshot, now: float) -> str:
    """Return the battery as `GOOD, 87.5 %, 24.1 V`, or why it is not known."""
    if snapshot.battery.received is None:
        return f"{battery_word(snapshot)[1]}, {no_reading_reason(snapshot)}"
    parts = (without_glyph(text).strip(" ()") for text, _ in battery_line(snapshot, now, _WIDTH))
    return ", ".join(part for part in parts if not part.startswith("--"))


def motion_text(snapshot: Snapshot, now: float) -> str:
    """Return the motion as `IDLE, 15420 ticks, 0.00 m/s`; unknown and old numbers are left out."""
    found, parts = snapshot.motion, [spans_to_text(motion_word(snapshot, now, _WIDTH))]
    if found.is_old(now):  # Old numbers would sound like current ones.
        return parts[0]
    if found.count is not None:
        parts.append(f"{found.count} {motion_unit(snapshot, 'count') or ''}".rstrip())
    if found.speed is not None:
        parts.append(speed_text(snapshot))
    parts += (text.strip() for text, _ in motion_age(snapshot, now))
    return ", ".join(parts)


def goal_text(snapshot: Snapshot, now: float, ask: str) -> str:
    """Return the goal's state, as `LOST, shelf 12, nothing heard for 3.0 s`, or `ask`."""
    text, found = spans_to_text(goal_line(snapshot, now, ask)), snapshot.goal
    text = text.replace(f", {NO_ESTIMATE}", "")  # Dashes are for the eye.
    if found is None or found.phase in (Phase.SENT, Phase.MOVING):
        return text
    if re.search(rf"(?<!\w){re.escape(found.name)}(?!\w)", text):
        return text
    word, _, rest = text.partition(", ")
    left = remaining_text(found) if found.phase is Phase.CANCELLING else ""
    return ", ".join(filter(None, (word, found.name, left, rest)))


def ended_goal_text(found: Goal) -> str:
    """Return a goal that ended as `shelf 12 arrived, 12:03:58`."""
    return f"{found.name} {found.word.lower()}, {time_of_day(found.time)}"


def queue_text(waiting: Sequence[str], held: str) -> str:
    """Return the waiting goals as `7, 3`, or `held: 7, 3 (cancelled)`; "" if none waits."""
    names = ", ".join(waiting)
    return f"held: {names} ({held})" if held and names else names
