"""ASCII in place of every glyph, for terminals that cannot show them."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rich.cells import cell_len

_TABLE = str.maketrans(
    {
        **dict.fromkeys("╭╮╰╯┌┐└┘├┤┬┴┼", "+"),
        **dict.fromkeys("┏┓┗┛█▇▉▊▋▍", "#"),
        **dict.fromkeys("─╌╍▔▃▄", "-"),
        **dict.fromkeys("━▅▆", "="),
        **dict.fromkeys("▁▂", "_"),
        **dict.fromkeys("│┃╎▌▐▏▕▎", "|"),
        "░": ".", "●": "*", "○": "o", "▲": "!", "✗": "x", "✓": "v", "↯": "~",
        "▶": ">", "←": "<", "→": ">",
        "…": ".", "\N{NO-BREAK SPACE}": " ",
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
