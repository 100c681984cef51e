"""ASCII in place of every glyph, for terminals that cannot show them."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rich.cells import cell_len

_ROWS = (0x09, 0x12, 0x24, 0xC0)  # the dots of a braille cell, from above
_BRAILLE = 0x2800


def _of_braille(dots: int) -> str:
    """A stroke about as high as the dots stand; `|` where they stand above each other."""
    rows = [number for number, mask in enumerate(_ROWS) if dots & mask]
    if not rows or len(rows) > 2:
        return "|" if rows else " "
    return "'--_"[rows[0]] if len(rows) == 1 else {0: "'", 1: "-", 2: "."}[rows[0]]


# `~` for what is cut, since it is in no name of ROS: with a `.` a shortened one reads as a real one
_TABLE = str.maketrans(
    {
        **{chr(_BRAILLE + dots): _of_braille(dots) for dots in range(256)},
        **dict.fromkeys("╭╮╰╯┌┐└┘├┤┬┴┼", "+"),
        **dict.fromkeys("┏┓┗┛█▇▉▊▋▍", "#"),
        **dict.fromkeys("─╌╍┄▔▃▄", "-"),
        **dict.fromkeys("━▅▆", "="),
        **dict.fromkeys("▁▂", "_"),
        **dict.fromkeys("│┃╎▌▐▏▕▎", "|"),
        "░": ".", "●": "*", "○": "o", "▲": "!", "✗": "x", "✓": "v", "↯": "~",
        **dict(zip("¹²³⁴⁵⁶⁷⁸⁹⁺", "abcdefghi+", strict=True)),  # no digits: they stand behind one
        "▶": ">", "←": "<", "→": ">",
        "…": "~", "\N{NO-BREAK SPACE}": " ",
    }
)  # fmt: skip


def ascii_only(environ: Mapping[str, str] = os.environ) -> bool:
    """True when the locale says that it is not UTF-8, and on Linux's own console.

    Without any word about the locale UTF-8 is assumed, as in containers and by Python itself.
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
