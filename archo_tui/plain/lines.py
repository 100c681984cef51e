"""Lines as they are typed: where they end, and which of them is a STOP. Pure."""

from __future__ import annotations

import re
import shlex

LONGEST = 64 * 1024  # bytes of a line that is taken
TOO_LONG = b"\n"  # in place of a line that is longer; no line can be that

# what a terminal sends for a key that is not a letter, or around what is pasted
_KEY = re.compile(r"\x1b(\[[0-?]*[ -/]*[@-~]|O[@-~])")
_STOP = re.compile(r"[\W_]*stop(?!\w)", re.IGNORECASE)


def is_stop(line: bytes) -> bool:
    """True when its first word is stop, whatever surrounds it: for a STOP no spelling is wrong."""
    line = line.replace(b"\0", b"")  # of a text in UTF-16
    if b"stop" not in line.lower():  # nearly no line has it, and this is fast
        return False
    return is_stop_text(line.decode(errors="replace"))


def is_stop_text(text: str) -> bool:
    """Return True for a STOP by the rule of `is_stop`, which every program here goes by."""
    if "stop" not in text.lower():
        return False
    return _STOP.match(text) is not None or _STOP.match(_KEY.sub("", text)) is not None


def words_of(line: bytes) -> list[str]:
    """Return the words of a line, as a shell splits it; none while a quote is not closed."""
    try:
        return shlex.split(line.decode(errors="replace"))
    except ValueError:
        return []


class LineCutter:
    """Cuts what is read into lines, at a cost that is linear whatever comes."""

    def __init__(self) -> None:
        self._rest = bytearray()
        self._skips = False  # the rest of a line that is too long

    def take(self, chunk: bytes) -> list[bytes]:
        """The lines that this piece ends, and one that becomes too long in it."""
        first, *others = chunk.replace(b"\r", b"\n").split(b"\n")  # a raw terminal sends returns
        found: list[bytes] = []
        self._keep(first, found)
        for part in others:
            if not self._skips:
                found.append(bytes(self._rest))
            self._rest, self._skips = bytearray(), False
            self._keep(part, found)
        return found

    def _keep(self, part: bytes, found: list[bytes]) -> None:
        if self._skips:
            return
        self._rest += part
        if len(self._rest) > LONGEST:
            head = bytes(self._rest[:LONGEST])
            found.append(head if is_stop(head) else TOO_LONG)
            self._rest, self._skips = bytearray(), True
