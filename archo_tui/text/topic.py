"""The texts of a topic that is open: how often messages come, and its fields. Pure functions."""

from __future__ import annotations

import math
from datetime import datetime

from archo_tui.robot.state.topic import SHOWN_ELEMENTS, Curve, FieldKind, FieldView, TopicView
from archo_tui.ros_names import base_name
from archo_tui.safe_text import harmless
from archo_tui.text.inspect import size_text
from archo_tui.text.state import BARS, OLD, PLAIN, STRONG, WARN, Spans, age_text, share, thousands

_FIRST_DATE = 1e8  # Unix seconds; an earlier stamp is a simulation's or a robot's own time.
_LAST_DATE = 2e11  # No later one can be written as a date.


def summary(view: TopicView, *, is_frozen: bool) -> Spans:
    """Return `11.3 Hz   0.7 kB/s   0.1 s old`, and what is wrong or out of the ordinary."""
    texts = []
    if view.rate is not None:
        texts.append(f"{view.rate:.1f} Hz")
    elif view.age is not None:
        texts.append("-- Hz")
    if view.bytes_per_second is not None:
        texts.append(f"{size_text(view.bytes_per_second)}/s")
    if view.age is not None:
        texts.append(f"{age_text(view.age)} old")
    elif view.type and not view.fault:
        texts.append("sent before" if view.received else "no message yet")
    frozen = ("   frozen: space shows new messages", STRONG) if is_frozen else ("", PLAIN)
    cut = f"   only the first {len(view.fields)} fields" if view.is_cut else ""
    line = "   ".join(texts)
    fault = f"{'   ' if line else ''}{view.fault}" if view.fault else ""
    return (line, PLAIN), frozen, (harmless(fault), WARN), (cut, OLD)


def value_text(field: FieldView) -> str:
    """Return what stands behind the name of a field: `12.3 m`, or `4 CHARGING` for a constant."""
    if field.kind is FieldKind.GROUP:
        return ""
    if field.kind is FieldKind.ARRAY:
        return f"{base_name(field.type)} {field.first}".rstrip()
    if field.kind is FieldKind.MORE:
        return f"enter shows {SHOWN_ELEMENTS} more of {field.value}"
    text = _value_text(field)
    if field.constant:
        return f"{text} {field.constant}"
    return f"{text} {field.unit}" if field.unit and text != "nan" else text


def _value_text(field: FieldView) -> str:
    value = field.value
    if field.is_time:
        return time_text(float(value or 0))
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return number_text(value)
    return harmless(str(value))


def number_text(value: float, digits: int = 7) -> str:
    """Return a number in few characters: an int with grouped digits, a float rounded."""
    if isinstance(value, int):
        return thousands(value)
    return str(value) if not math.isfinite(value) else f"{value:.{digits}g}"


def range_text(field: FieldView) -> str:
    """Return `0.12 .. 9.8, 3 nan`: the range of an array, or of a number's values so far."""
    parts = []
    if field.least is not None and field.greatest is not None:
        parts.append(f"{_short(field.least)} .. {_short(field.greatest)}")
    if field.nan:
        parts.append(f"{field.nan} nan")
    return ", ".join(parts)


def _short(value: float) -> str:
    """Return a number with four digits, or from 10,000 to a billion as a whole number."""
    is_long = 1e4 <= abs(value) < 1e9
    return number_text(round(value) if is_long else value, digits=4)


def time_text(seconds: float) -> str:
    """Return a Unix time as the local time, `12:04:31.250`, or in seconds without a date."""
    if not _FIRST_DATE <= seconds <= _LAST_DATE:
        return f"{seconds:.3f} s"
    return f"{datetime.fromtimestamp(seconds):%H:%M:%S.%f}"[:-3]


def sparkline(curve: Curve) -> str:
    """Return a bar for each column of a curve, scaled from its least to its greatest value."""
    known = [value for both in curve if both is not None for value in both]
    if not known:
        return ""
    low, high = min(known), max(known)
    bars, before = "", known[0]
    for both in curve:
        if both is None:
            bars += " "
            continue
        before = max(both, key=lambda value: abs(value - before))
        bars += BARS[round(share(before, low, high) * (len(BARS) - 1))]
    return bars
