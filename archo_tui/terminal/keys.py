"""The key events of escape sequences: Textual's table, kitty's protocol, and modifyOtherKeys.

Textual reads kitty's sequences, too, but it raises on those with alternate keys, and recognizes
ctrl+x only if the layout has an x. https://sw.kovidgoyal.net/kitty/keyboard-protocol/
"""

from __future__ import annotations

import re
import unicodedata

from textual import events
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual._keyboard_protocol import FUNCTIONAL_KEYS, MODIFIER_FUNCTIONAL_KEYS
from textual.keys import ASCII_KEY_NAMES, KEY_NAME_REPLACEMENTS

# The QWERTY key on which a letter is printed: under a Russian layout ctrl+x is ctrl+ч for a
# terminal that does not tell which key was pressed.
_ALPHABETS = (
    ("йцукенгшщзхъфывапролджэячсмитьбюё", "qwertyuiop[]asdfghjkl;'zxcvbnm,.`"),  # Russian
    ("іїєґ", "s]'\\"),  # Ukrainian, besides those.
    ("ςερτυθιοπασδφγηξκλζχψωβνμ", "wertyuiopasdfghjklzxcvbnm"),  # Greek
)
_ON_QWERTY = {
    letter: key for row, keys in _ALPHABETS for letter, key in zip(row, keys, strict=True)
}


def key_name(character: str) -> str:
    """Return Textual's name of the key that types a character, as `x` or `question_mark`."""
    name = character
    if not character.isalnum():
        known = unicodedata.name(character, "") or ASCII_KEY_NAMES.get(character, character)
        name = known.lower().replace("-", "_").replace(" ", "_")
    return KEY_NAME_REPLACEMENTS.get(name, name)


def on_qwerty(letter: str) -> str:
    """Return the character of a Cyrillic or Greek letter's QWERTY key; any other unchanged."""
    return _ON_QWERTY.get(letter.lower(), letter)


_EXTENDED = re.compile(r"\x1b\[([\d:]*)(?:;([\d:]*))?(?:;([\d:]*))?([u~ABCDEFHPQRS])")
_SHIFT, _ALT, _CTRL, _SUPER, _HYPER, _META, _CAPS_LOCK = (1 << bit for bit in range(7))
_MODIFIERS = {"alt": _ALT, "ctrl": _CTRL, "super": _SUPER, "hyper": _HYPER, "meta": _META}
_NO_TEXT = _CTRL | _SUPER | _HYPER | _META
_RELEASED = 3
_OTHER_KEYS = 27  # The first number of xterm's modifyOtherKeys sequences.
_CHARACTERS = {"backspace": "\x7f", "enter": "\r", "tab": "\t"}


def keys_of(sequence: str) -> list[events.Key] | None:
    """Return the keys of a whole escape sequence, [] for one let go; None if it is no key."""
    if match := _EXTENDED.fullmatch(sequence):
        keys = _extended(*(match[group] or "" for group in range(1, 5)))
        if keys is not None:
            return keys
    named = ANSI_SEQUENCES_KEYS.get(sequence)
    if named is None:
        return None
    if isinstance(named, str):
        return [events.Key(key_name(named), named)]
    return [events.Key(key.value, None) for key in named] if isinstance(named, tuple) else []


def alt_key(character: str) -> events.Key:
    """Return the key that an escape before a character means; it types nothing."""
    name = key_name(character)
    return events.Key(f"alt+shift+{name.lower()}" if name.isupper() else f"alt+{name}", None)


def _extended(codes: str, modifiers: str, text: str, final: str) -> list[events.Key] | None:
    code, shifted, base = _numbers(codes, 3)[:3]
    state, event = _numbers(modifiers, 2)[:2]
    held = max(state or 1, 1) - 1
    if held > 0xFF or (event or 1) > _RELEASED:
        return None
    if event == _RELEASED:
        return []
    typed = [char for number in _numbers(text) if (char := _printable(number))]
    if final == "~" and code == _OTHER_KEYS and text:
        code, final = _numbers(text)[0], "u"
        typed = [] if held & _ALT else typed
    if held & _NO_TEXT:
        typed = []
    if code is None and final not in "u~":
        code = 1  # As in `CSI A`.
    name = FUNCTIONAL_KEYS.get(f"{code}{final}")
    if name is not None:
        return [_key(name, char, held) for char in typed or [""]]
    character = _printable(code)
    if not character or final != "u":
        return None
    if not typed and not held & (_ALT | _NO_TEXT):  # The terminal does not report the text.
        untold = _printable(shifted) if held & _SHIFT else character
        typed = [untold] if untold else []
    if typed:
        lower = held & _CAPS_LOCK and not held & _SHIFT
        return [_key(key_name(c.lower() if lower else c), c, held) for c in typed]
    if not character.isascii():
        character = _printable(base) or on_qwerty(character)
    return [_key(key_name(character.lower()), "", held)]


def _key(name: str, character: str, held: int) -> events.Key:
    """Return a key event, whose name lacks the modifiers that its character includes."""
    with_shift = held & _SHIFT and (not character or character.isspace())
    words = ["shift"] if with_shift else []
    words += [word for word, bit in _MODIFIERS.items() if held & bit]
    if character:
        words = [word for word in words if word != "alt"]
    if name in MODIFIER_FUNCTIONAL_KEYS:
        words = []
    known = "" if words else _CHARACTERS.get(name, "")
    return events.Key("+".join([*sorted(words), name]), character or known or None)


def _numbers(text: str, count: int = 0) -> list[int | None]:
    """Return the numbers between colons, None for an empty one, filled up with None to `count`."""
    numbers = [int(part) if part else None for part in text.split(":")]
    return numbers + [None] * (count - len(numbers))


def _printable(number: int | None) -> str:
    """Return the character of a code point, or "" if there is none or it cannot be typed."""
    if number is None or number > 0x10FFFF:
        return ""
    return chr(number) if chr(number).isprintable() else ""
