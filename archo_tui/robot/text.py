"""Text from outside: the one place that knows what a terminal could act on.

Everything that reaches a terminal goes through here: each line of the screen (terminal/app.py),
of `--plain`, and of what is said on standard error.
"""

from __future__ import annotations

import re

from rich.cells import cell_len

_LONGEST = 500  # characters of a line that are kept
_MARKS = 4  # combining marks on one letter: more would reach into the lines around
HIDDEN = "\N{REPLACEMENT CHARACTER}"  # what stands for a character that is not shown
# what U+200C and U+200D stand between inside a word: Arabic and Indic letters, emoji
_JOINED = (
    "[\u0620-\u065f\u066e-\u06ff\u0750-\u077f\u0840-\u08ff\u0900-\u0dff\u1000-\u109f"
    "\u1780-\u17b3\u17b6-\u17d3\u2600-\u27bf\u2b00-\u2bff\ufe0f\ufb50-\ufdff\ufe70-\ufefc"
    "\U0001f000-\U0001faff]"
)
# C0 and C1 controls; marks that turn the direction of text around or hide; joiners outside of
# words; other line ends; lone surrogates, which no encoding of a terminal can hold; tags, which
# carry unseen text
_UNSAFE = re.compile(
    f"(?<!{_JOINED})[\u200c\u200d]|[\u200c\u200d](?!{_JOINED})|"
    "[\x00-\x1f\x7f-\x9f\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f"
    "\ufeff\ufff9-\ufffb\ud800-\udfff\U000e0000-\U000e007f]"
)
# letters and marks that look like a blank or like nothing at all
_UNSEEN = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0"
    "\U000e0100-\U000e01ef]"
)
_COMBINING = "[\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]"
_HEAPED = re.compile(f"({_COMBINING}{{{_MARKS}}}){_COMBINING}+")


def safe(text: str) -> str:
    """One line of text without anything that a terminal could act on."""
    if text.isascii() and text.isprintable():  # nearly all is, and this is fast
        return text
    return _HEAPED.sub(r"\1", _UNSAFE.sub(HIDDEN, text))


def safe_in_place(text: str) -> str:
    """The same in as many cells, for a line that was laid out already."""
    text = _UNSAFE.sub(lambda found: HIDDEN * cell_len(found[0]), text)
    return _HEAPED.sub(r"\1", text)


def hides(text: str) -> bool:
    """True when a person who reads it would take it for another one."""
    is_plain = text.isprintable() and text == " ".join(text.split()) and harmless(text) == text
    return not is_plain or _UNSEEN.search(text) is not None


def harmless(text: str) -> str:
    """One line of text that is safe and of bounded length, for whatever is kept of it."""
    text = safe(text[: _LONGEST + 1])
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
