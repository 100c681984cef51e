"""Reports of the mouse and the focus."""

from __future__ import annotations

import re

REPORT = re.compile(r"\x1b\[(?:<\d{1,5};-?\d{1,5};-?\d{1,5}[Mm]|[IO])")
_RUN = re.compile(r"(?:\x1b\[<\d{1,5};-?\d{1,5};-?\d{1,5}M){2,}")  # With nothing between them.
_PRESS = re.compile(r"\x1b\[<(\d{1,5});-?\d{1,5};-?\d{1,5}M")
_MOVES, _WHEEL = 32, 64  # Bits of the button code.


def drop_passed_moves(text: str) -> str:
    """Return a text without mouse moves that another one with the same buttons follows."""
    return _RUN.sub(lambda run: "".join(_last_moves(run[0])), text)


def _last_moves(run: str) -> list[str]:
    """Return the reports of a run without each move that a later one with equal buttons follows.

    A press, or a turn of the wheel, separates two runs.
    """
    kept: list[str] = []
    seen: set[str] = set()
    for report in reversed(list(_PRESS.finditer(run))):
        if int(report[1]) & (_MOVES | _WHEEL) != _MOVES:
            seen.clear()  # A button or the wheel separates two runs of moves.
        elif report[1] in seen:
            continue
        else:
            seen.add(report[1])
        kept.append(report[0])
    return kept[::-1]


def split_reports(text: str) -> tuple[list[str], str]:
    """Return the mouse and focus reports in a text, each a sequence, and the text without them."""
    return [report[0] for report in REPORT.finditer(text)], REPORT.sub("", text)
