"""Reports of the mouse and the focus: of many moves in a row only the last one counts."""

from __future__ import annotations

import re

REPORT = re.compile(r"\x1b\[(?:<\d{1,5};-?\d{1,5};-?\d{1,5}[Mm]|[IO])")
# followed by another one of the same buttons
_OVERTAKEN = re.compile(r"\x1b\[<(\d{1,5});-?\d{1,5};-?\d{1,5}M(?=\x1b\[<\1;-?\d{1,5};-?\d{1,5}M)")
_MOVES, _WHEEL = 32, 64  # bits of the button code


def last_moves(text: str) -> str:
    """The text without the moves that another one follows; all else stays, in its order."""
    return _OVERTAKEN.sub(_unless_a_move, text)


def _unless_a_move(report: re.Match[str]) -> str:
    return "" if int(report[1]) & (_MOVES | _WHEEL) == _MOVES else report[0]


def apart(text: str) -> tuple[list[str], str]:
    """The reports in a text, and all else."""
    return [report[0] for report in REPORT.finditer(text)], REPORT.sub("", text)
