"""A decoder of a terminal's bytes: UTF-8, and the 8-bit controls of ECMA-48."""

from __future__ import annotations

import codecs


def _replace_or_control(error: UnicodeError) -> tuple[str, int]:
    """Return U+FFFD or an 8-bit control for bytes that are not UTF-8, and where they end."""
    assert isinstance(error, UnicodeDecodeError)
    wrong = error.object[error.start : error.end]
    is_control = len(wrong) == 1 and 0x80 <= wrong[0] <= 0x9F
    return (chr(wrong[0]) if is_control else "\N{REPLACEMENT CHARACTER}"), error.end


codecs.register_error("archo-terminal", _replace_or_control)


class Decoder:
    """An incremental decoder that keeps the bytes of an incomplete character for the next call."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("archo-terminal")

    def decode(self, data: bytes, *, after_a_pause: bool) -> str:
        """Return the text that the bytes complete; never raise, and drop what a pause cut off."""
        if after_a_pause and data[:1].isascii():
            self._decoder.reset()  # The rest of the character will not come.
        return self._decoder.decode(data)

    @property
    def is_amid_character(self) -> bool:
        return self._decoder.getstate()[0] != b""
