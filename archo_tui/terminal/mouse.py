"""Reports of the mouse and the focus: of many moves in a row only the last one counts."""

from __future__ import annotations

import re

REPORT = re.compile(r"\x1b\[(?:<\d{1,5};-?\d{1,5};-?\d{1,5}[Mm]|[IO])")
_RUN = re.compile(r"(?:\x1b\[<\d{1,5};-?\d{1,5};-?\d{1,5}M){2,}")  # nothing between them
_PRESS = re.compile(r"\x1b\[<(\d{1,5});-?\d{1,5};-?\d{1,5}M")
_MOVES, _WHEEL = 32, 64  # bits of the button code


def last_moves(text: str) -> str:
    """The text without the moves that another one follows; all else stays, in its order.

    Of a run of moves the last one with each state of the buttons stays.
    """
    return _RUN.sub(lambda run: "".join(_lasting(run[0])), text)


def _lasting(run: str) -> list[str]:
    kept: list[str] = []
    seen: set[str] = set()
    for report in reversed(list(_PRESS.finditer(run))):
        if int(report[1]) & (_MOVES | _WHEEL) != _MOVES:
            seen.clear()  # a button or the wheel: what came before it is another run
        elif report[1] in seen:
            continue
        else:
            seen.add(report[1])
        kept.append(report[0])
    return kept[::-1]


def apart(text: str) -> tuple[list[str], str]:
    """The reports in a text, and all else."""
    return [report[0] for report in REPORT.finditer(text)], REPORT.sub("", text)
