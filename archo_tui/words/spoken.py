"""What is said line by line: for ears as well, without glyphs, columns or grouped digits. Pure."""

from __future__ import annotations

import re
from collections.abc import Sequence

from archo_tui.clock import time_of_day
from archo_tui.robot.state import Goal, Phase, Snapshot
from archo_tui.words.goal import goal_line
from archo_tui.words.state import (
    Spans,
    battery_source,
    battery_word,
    faster,
    motion_unit,
    motion_word,
)

_GLYPHS = "●○✗✓▲▶↯? "  # each stands before a word that says the same
_WIDTH = 80  # cells, within which nothing is shortened


def in_words(spans: Spans) -> str:
    """`MOVING to 12, 9.0 m left of 18.0 m`: commas where the screen leaves a gap."""
    parts = (part for text, _ in spans for part in re.split(" {2,}", text.strip()))
    return bare(", ".join(filter(None, parts)))


def bare(text: str) -> str:
    """Without the glyph before it."""
    return text.lstrip(_GLYPHS)


def battery(snapshot: Snapshot, now: float) -> str:
    """`GOOD, 87.5 %, 24.1 V`; what is not known is left out."""
    found = snapshot.battery
    _, word, _ = battery_word(snapshot)
    if found.received is None:
        return f"{word}, {battery_source(snapshot)}"
    if found.unreadable:
        return word
    parts = [word]
    if found.percentage is not None:
        parts.append(f"{found.percentage:.1f} %")
    if found.is_old(now):
        parts.append(f"old, {now - found.received:.0f} s")
    elif found.voltage is not None:
        parts.append(f"{found.voltage:.1f} V")
    return ", ".join(parts)


def motion(snapshot: Snapshot, now: float) -> str:
    """`IDLE, 15420 ticks, 0.00 m/s`: what of it the robot file names, and is known."""
    found, parts = snapshot.motion, [in_words(motion_word(snapshot, now, _WIDTH))]
    if found.is_old(now):  # they would sound as if they were of now
        return parts[0]
    if found.count is not None:
        parts.append(f"{found.count} {motion_unit(snapshot, 'count') or ''}".rstrip())
    if found.speed is not None:
        speed = f"{found.speed:.2f} {motion_unit(snapshot, 'speed') or ''}".rstrip()
        parts.append(f"{speed} {faster(snapshot)}".rstrip())
    return ", ".join(parts)


def goal(snapshot: Snapshot, now: float, ask: str) -> str:
    """`MOVING to 12, 9.0 m left of 18.0 m`, or `LOST, shelf 12, nothing heard for 3.0 s ...`.

    On the screen the way stands beside it; here the line says itself which goal it is about.
    """
    said, found = in_words(goal_line(snapshot, now, ask)), snapshot.goal
    if found is None or found.phase in (Phase.SENT, Phase.MOVING):
        return said
    if re.search(rf"(?<!\w){re.escape(found.name)}(?!\w)", said):
        return said
    word, _, rest = said.partition(", ")
    return ", ".join(filter(None, (word, found.name, rest)))


def ended(found: Goal) -> str:
    """`shelf 12 arrived, 12:03:58`."""
    return f"{found.name} {found.word.lower()}, {time_of_day(found.time)}"


def queue(waiting: Sequence[str], held: str) -> str:
    """`7, 3`, or `held: 7, 3 (cancelled)`; empty when nothing waits."""
    names = ", ".join(waiting)
    return f"held: {names} ({held})" if held and names else names
