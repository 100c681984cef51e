"""The words that are a STOP, typed or sent. Pure: every program of this project decides here."""

from __future__ import annotations

import re
import shlex

# The escape sequences (ECMA-48: CSI, SS3, OSC) that a terminal sends for a key without a letter,
# around pasted text, or as a reply; the Linux console's F1 to F5, rxvt's shifted keys, and a lone
# escape, as alt sends it.
_KEY = re.compile(
    r"\x1b*(\x1b\[\[[A-E]|\x1b\[\d+\$|(\x1b\[|\x9b)[0-?]*[ -/]*[@-~]|\x1bO\d*[@-~]"
    r"|\x1b\][^\x07\x1b]*(\x07|\x1b\\)|\x1b)"
)
_STOP = re.compile(r"[\W_]*stop(?!\w)", re.IGNORECASE)


def is_stop(line: bytes) -> bool:
    """Return True if the first word of a line is `stop`; `stopped` is no STOP.

    Case, NULs (of UTF-16), the escape sequences of keys, punctuation and bytes that are not UTF-8
    do not matter: a person who types STOP in a hurry must not be refused.
    """
    line = line.replace(b"\0", b"")  # ASCII text that was encoded in UTF-16.
    # Most lines end here: decoding is slower. A key's sequence may stand within the word.
    if b"stop" not in line.lower() and b"\x1b" not in line and b"\xc2\x9b" not in line:
        return False
    return is_stop_text(line.decode(errors="replace"))


def is_stop_text(text: str) -> bool:
    """Return True if the first word of a text is `stop`, by the rule of `is_stop` but for NULs."""
    has_keys = "\x1b" in text or "\x9b" in text
    spellings = (text, _KEY.sub("", text)) if has_keys else (text,)
    return any("stop" in spelling.lower() and _STOP.match(spelling) for spelling in spellings)


def shell_words(line: bytes) -> list[str]:
    """Return the words of a line, split as by a shell; [] if a quote is left open."""
    try:
        return shlex.split(line.decode(errors="replace"))
    except ValueError:
        return []
