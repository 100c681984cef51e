"""The removal of characters on which a terminal could act from texts of other programs.

Every line for a terminal passes through here: those of the screen (screen/terminal/app.py), of
`--plain`, of shell verbs, and of standard error. Importing this takes little time: a prompt may run
a verb.
"""

from __future__ import annotations

import re

_LONGEST = 500  # Characters of a line that are kept.
_MARKS = 4  # Combining marks on one letter; more would reach into the lines above and below.
HIDDEN = "\N{REPLACEMENT CHARACTER}"  # Stands for a character that is not shown.
# Between these, U+200C and U+200D are part of a word: Arabic and Indic letters, emoji.
_JOINED = (
    "[\u0620-\u065f\u066e-\u06ff\u0750-\u077f\u0840-\u08ff\u0900-\u0dff\u1000-\u109f"
    "\u1780-\u17b3\u17b6-\u17d3\u2600-\u27bf\u2b00-\u2bff\ufe0f\ufb50-\ufdff\ufe70-\ufefc"
    "\U0001f000-\U0001faff]"
)
# C0 and C1 controls; marks that reverse the direction of text or are invisible; joiners outside of
# words; other line ends; lone surrogates, which no encoding of a terminal has; tags, which carry
# invisible text.
_UNSAFE = re.compile(
    f"(?<!{_JOINED})[\u200c\u200d]|[\u200c\u200d](?!{_JOINED})|"
    "[\x00-\x1f\x7f-\x9f\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f"
    "\ufeff\ufff9-\ufffb\ud800-\udfff\U000e0000-\U000e007f]"
)
# Letters and marks that look like a blank or like nothing.
_UNSEEN = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0f\uffa0"
    "\U000e0100-\U000e01ef]"
)
_COMBINING = "[\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]"
_HEAPED = re.compile(f"({_COMBINING}{{{_MARKS}}}){_COMBINING}+")


def safe(text: str) -> str:
    """Return a line with HIDDEN for each character, line ends too, that a terminal could act on."""
    if text.isascii() and text.isprintable():  # Most texts end here: this is fast.
        return text
    return _HEAPED.sub(r"\1", _UNSAFE.sub(HIDDEN, text))


def safe_lines(text: str) -> str:
    """Return a text of several lines with each line as `safe` returns it; line feeds stay."""
    return "\n".join(map(safe, text.split("\n")))


def safe_in_place(text: str) -> str:
    """Return what `safe` does, with the width in cells unchanged, for a line that is laid out."""
    return _HEAPED.sub(r"\1", _UNSAFE.sub(_hidden_in_place, text))


def _hidden_in_place(found: re.Match[str]) -> str:
    from rich.cells import cell_len  # Only a screen needs it, which has imported it before.

    return HIDDEN * cell_len(found[0])


def is_deceptive(text: str) -> bool:
    """Return True if a text may look like another text to a person, or is very long."""
    is_plain = text.isprintable() and text == " ".join(text.split()) and harmless(text) == text
    return not is_plain or _UNSEEN.search(text) is not None


def harmless(text: str) -> str:
    """Return a text as a safe line of at most 500 characters and ` ...`; line feeds are blanks."""
    return harmless_lines(text).replace("\n", " ")


def harmless_lines(text: str) -> str:
    """Return a text as `harmless` does, but with its line feeds, other than those at its end."""
    text = safe_lines(text[: _LONGEST + 1].replace("\r\n", "\n").rstrip("\n"))
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
