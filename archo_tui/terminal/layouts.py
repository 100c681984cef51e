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
    """Return the character of the QWERTY key on which a Cyrillic or Greek letter is printed.

    A capital letter gives the same as a small one; any other character is returned unchanged.
    """
    return _ON_QWERTY.get(letter.lower(), letter)
