"""Bytes of a terminal as text: UTF-8, and the 8-bit controls, which are not UTF-8."""

from __future__ import annotations

import codecs


def _lenient(error: UnicodeError) -> tuple[str, int]:
    """A byte from 0x80 to 0x9f alone is the control of that number; all else is unreadable."""
    assert isinstance(error, UnicodeDecodeError)
    wrong = error.object[error.start : error.end]
    is_control = len(wrong) == 1 and 0x80 <= wrong[0] <= 0x9F
    return (chr(wrong[0]) if is_control else "\N{REPLACEMENT CHARACTER}"), error.end


codecs.register_error("archo-terminal", _lenient)


class Decoder:
    """Takes bytes as they come, and keeps a character that is not complete."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("archo-terminal")

    def decode(self, data: bytes, *, after_a_pause: bool) -> str:
        """What can be read so far; it raises nothing."""
        if after_a_pause and data[:1].isascii():
            self._decoder.reset()  # what was begun will not be completed: the key stands alone
        return self._decoder.decode(data)

    @property
    def is_amid_a_character(self) -> bool:
        """True when the last read ended there."""
        return self._decoder.getstate()[0] != b""
