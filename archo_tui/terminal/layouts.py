"""Letters of other alphabets by the key that they are printed on, as a QWERTY keyboard names it.

ctrl+x under a Russian layout is ctrl+ч for a terminal that does not say which key was pressed.
"""

from __future__ import annotations

_PLACES = (
    ("йцукенгшщзхъфывапролджэячсмитьбюё", "qwertyuiop[]asdfghjkl;'zxcvbnm,.`"),  # Russian
    ("іїєґ", "s]'\\"),  # what Ukrainian has besides
    ("ςερτυθιοπασδφγηξκλζχψωβνμ", "wertyuiopasdfghjklzxcvbnm"),  # Greek
)
_ON_QWERTY = {letter: key for row, keys in _PLACES for letter, key in zip(row, keys, strict=True)}


def on_qwerty(letter: str) -> str:
    """The key of that letter; a letter of an unknown alphabet stays what it is."""
    return _ON_QWERTY.get(letter.lower(), letter)
