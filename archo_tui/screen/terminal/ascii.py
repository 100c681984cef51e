"""ASCII in place of glyphs, for terminals that cannot show them."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rich.cells import cell_len

_DOT_ROWS = (0x09, 0x12, 0x24, 0xC0)  # The masks of a braille cell's rows of dots, from above.
_BRAILLE = 0x2800


def _braille_in_ascii(dots: int) -> str:
    """Return an ASCII character about as high as a braille cell's dots, given as bits."""
    rows = [number for number, mask in enumerate(_DOT_ROWS) if dots & mask]
    if not rows or len(rows) > 2:
        return "|" if rows else " "
    return "'--_"[rows[0]] if len(rows) == 1 else {0: "'", 1: "-", 2: "."}[rows[0]]


# `…` becomes `~`, which no ROS name contains: with a `.` a shortened name would look like a name.
_TABLE = str.maketrans(
    {
        **{chr(_BRAILLE + dots): _braille_in_ascii(dots) for dots in range(256)},
        **dict.fromkeys("╭╮╰╯┌┐└┘├┤┬┴┼", "+"),
        **dict.fromkeys("┏┓┗┛█▇▉▊▋▍", "#"),
        **dict.fromkeys("─╌╍┄▔▃▄▀", "-"),
        **dict.fromkeys("━▅▆", "="),
        **dict.fromkeys("▁▂", "_"),
        **dict.fromkeys("│┃╎▌▐▏▕▎‖", "|"),
        "░": ".", "·": ".", "●": "*", "○": "o", "▲": "!", "✗": "x", "✓": "v", "↯": "~",
        "°": "*", "²": "2", "³": "3", "µ": "u", "×": "x",  # Of units.
        "▶": ">", "▸": ">", "▾": "v", "←": "<", "→": ">", "↑": "^", "↓": "v",
        "…": "~", "\N{NO-BREAK SPACE}": " ",
    }
)  # fmt: skip


def ascii_only(environ: Mapping[str, str] = os.environ) -> bool:
    """Return True if the terminal shows ASCII only, as far as the environment tells.

    That is Linux's own console, and every locale that is not UTF-8. Without a locale UTF-8 is
    assumed, as Python does.
    """
    if environ.get("TERM") == "linux":
        return True
    values = (environ.get(name, "") for name in ("LC_ALL", "LC_CTYPE", "LANG"))
    locale = next((text for text in values if text and text != _COERCED), environ.get("LANG", ""))
    return bool(locale) and "utf" not in locale.lower()


_COERCED = "C.UTF-8"  # Python sets LC_CTYPE to it under the C locale (PEP 538).


def in_ascii(text: str) -> str:
    """Return a text in ASCII with the same width in cells; unknown characters become `?`."""
    text = text.translate(_TABLE)
    if text.isascii():
        return text
    return "".join(char if char.isascii() else "?" * cell_len(char) for char in text)
