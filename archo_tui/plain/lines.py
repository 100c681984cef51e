"""The rules for typed lines: where a line ends, and which line is a STOP.

Pure functions. Every program of this project decides by `is_stop` and `is_stop_text` what a STOP
is.
"""

from __future__ import annotations

import re
import shlex

MAX_LINE = 64 * 1024  # Bytes of a line that is accepted.
TOO_LONG = b"\n"  # Stands for a longer line; no line can be equal to it.

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
    """Return the words of a line, split as by a shell; [] if a quote or a backslash is left open.

    Bytes that are not UTF-8 become replacement characters.
    """
    try:
        return shlex.split(line.decode(errors="replace"))
    except ValueError:
        return []


class LineSplitter:
    """A splitter of a stream of bytes into lines, which keeps the unfinished last line."""

    def __init__(self) -> None:
        self._rest = bytearray()  # The beginning of a line whose end was not read yet.
        self._is_skipping = False  # The end of a line that is too long.

    def feed(self, chunk: bytes) -> list[bytes]:
        """Return the lines that end in this chunk, at a line feed or a carriage return.

        A line beyond `MAX_LINE` is returned as soon as it is: as its beginning if that is a STOP,
        else as `TOO_LONG`. The rest of it is dropped.
        """
        first, *others = chunk.replace(b"\r", b"\n").split(b"\n")  # A raw terminal sends returns.
        lines: list[bytes] = []
        self._append(first, lines)
        for part in others:
            if not self._is_skipping:
                lines.append(bytes(self._rest))
            self._rest, self._is_skipping = bytearray(), False
            self._append(part, lines)
        return lines

    def _append(self, part: bytes, lines: list[bytes]) -> None:
        """Add a part to the current line; if that becomes too long, add its stand-in to `lines`."""
        if self._is_skipping:
            return
        self._rest += part
        if len(self._rest) > MAX_LINE:
            head = bytes(self._rest[:MAX_LINE])
            lines.append(head if is_stop(head) else TOO_LONG)
            self._rest, self._is_skipping = bytearray(), True
