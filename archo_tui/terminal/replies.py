"""Patterns of what a terminal sends that is not a key: reports for Textual, and replies to drop."""

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


# Reports of mouse, focus, size, modes and cursor, in the forms that Textual's parser expects.
FOR_TEXTUAL = re.compile(
    rf"{REPORT.pattern}"
    r"|\x1b\[\d{1,5};\d{1,5};\d{1,5}M"  # urxvt's mouse
    r"|\x1b\[M[^\x00-\x1f]{3}"  # X10's
    r"|\x1b\[48(?=.{1,28}\Z)(?:;[1-9]\d{0,3}(?::\d{1,5})?){2}(?:;\d{1,6}(?::\d{1,5})?){2}t"
    r"|\x1b\[\?20(?:26|48);\d\$y"
    r"|\x1b\[\d{1,5};\d{1,5}R"
)
# Control sequences that reply to a query: attributes, modes, states, sizes.
REPLY = re.compile(r"\x1b\[(?:[?>=][\d;]+[ -/]*[@-~]|[\d;]+(?:[cnRtx]|\$y))")
# The start of a control string that is a reply, without its escape: colours, clipboard, graphics.
REPLY_START = re.compile(r"\]\d+;|P(?:[>!]\||[01][+$]r|\d+[;!$])|_G")
# What may become such a string, or is one that only its end tells: titles, PM, SOS.
_ANY = r"(?:\][lL]|[\^X])[^\x00-\x1f\x7f-\x9f]*"
MAY_BE_REPLY = re.compile(rf"\]\d{{0,4}}|P[>!]?|P\d{{1,4}}|P[01]\+|_|{_ANY}\x1b?")
WHOLE_STRING = re.compile(rf"{_ANY}(?:\x07|\x9c|\x1b\\)")
