"""ASCII in place of every glyph, for terminals that cannot show them."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rich.cells import cell_len
from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

_TABLE = str.maketrans(
    {
        **dict.fromkeys("╭╮╰╯┌┐└┘├┤┬┴┼", "+"),
        **dict.fromkeys("┏┓┗┛█▇▉▊▋▍", "#"),
        **dict.fromkeys("─╌╍▔▃▄", "-"),
        **dict.fromkeys("━▅▆", "="),
        **dict.fromkeys("▁▂", "_"),
        **dict.fromkeys("│┃╎▌▐▏▕▎", "|"),
        "░": ".", "●": "*", "○": "o", "▲": "!", "✗": "x", "✓": "v", "↯": "~", "▶": ">",
        "…": ".", "\N{NO-BREAK SPACE}": " ",
    }
)  # fmt: skip


def ascii_only(environ: Mapping[str, str] = os.environ) -> bool:
    """True for a locale that is said to be without UTF-8, and for Linux's own console.

    Nothing said about the locale is taken for UTF-8: so are containers, and Python itself.
    """
    if environ.get("TERM") == "linux":
        return True
    said = (environ.get(name, "") for name in ("LC_ALL", "LC_CTYPE", "LANG"))
    locale = next((text for text in said if text and text != _COERCED), environ.get("LANG", ""))
    return bool(locale) and "utf" not in locale.lower()


_COERCED = "C.UTF-8"  # what Python itself puts into LC_CTYPE where the locale is C (PEP 538)


def in_ascii(text: str) -> str:
    """The text with as many cells, in ASCII."""
    text = text.translate(_TABLE)
    if text.isascii():
        return text
    return "".join(char if char.isascii() else "?" * cell_len(char) for char in text)


class Ascii(LineFilter):
    """Changes what is drawn, whatever draws it."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment if segment.control else Segment(in_ascii(segment.text), segment.style)
            for segment in segments
        ]
