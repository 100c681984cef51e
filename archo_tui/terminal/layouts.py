"""The QWERTY key on which a letter of another alphabet is printed.

Under a Russian layout ctrl+x is ctrl+ч for a terminal that does not tell which key was pressed.
"""

from __future__ import annotations

_ALPHABETS = (
    ("йцукенгшщзхъфывапролджэячсмитьбюё", "qwertyuiop[]asdfghjkl;'zxcvbnm,.`"),  # Russian
    ("іїєґ", "s]'\\"),  # Ukrainian, besides those.
    ("ςερτυθιοπασδφγηξκλζχψωβνμ", "wertyuiopasdfghjklzxcvbnm"),  # Greek
)
_ON_QWERTY = {
    letter: key for row, keys in _ALPHABETS for letter, key in zip(row, keys, strict=True)
}


def on_qwerty(letter: str) -> str:
    """Return the character of a Cyrillic or Greek letter's QWERTY key; any other unchanged."""
    return _ON_QWERTY.get(letter.lower(), letter)
