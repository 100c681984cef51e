"""A parser of constants and defaults in interface files, equal to rosidl_adapter's.

A value that is not valid raises ValueError with one line that says what was expected.
"""

from __future__ import annotations

import re
import warnings

from .idl_types import FLOATS, INTEGERS, FieldType

_SHOWN = 40  # Characters of a wrong value that an error quotes.
_BOOLS = {"true": True, "1": True, "false": False, "0": False}
_ELEMENT = re.compile(  # An element of a list of texts, up to the comma.
    r""" *(?:"((?:[^"\\]|\\.)*)"|'((?:[^'\\]|\\.)*)'|([^,"' ][^,]*)) *,?"""
)


def read(text: str, kind: FieldType) -> object:
    r"""Return the value of a constant or default as its text in an interface file means it.

    A byte is an int, an array a list. Escapes such as `\n` are decoded in a single text, but not
    in an array of texts.
    """
    if "/" in kind.base:
        raise ValueError(f"{kind.base} takes no default")
    if not kind.is_array:
        return _single(text, kind)
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError(f"expected a list like [1, 2], not {text[:_SHOWN]}")
    inside = text[1:-1]
    if kind.base in ("string", "wstring"):
        items = _texts(inside)  # Their escapes are not decoded.
    else:
        items = inside.split(",") if inside else []
    if kind.fixed_size is not None and len(items) != kind.fixed_size:
        raise ValueError(f"expected {kind.fixed_size} values, not {len(items)}")
    if kind.upper_bound is not None and len(items) > kind.upper_bound:
        raise ValueError(f"expected at most {kind.upper_bound} values, not {len(items)}")
    element = kind._replace(is_array=False, fixed_size=None, upper_bound=None)
    return [_single(item.strip(), element, is_element=True) for item in items]


def _single(text: str, kind: FieldType, *, is_element: bool = False) -> object:
    if kind.base in ("string", "wstring"):
        read = _text(text, kind.string_bound)
        return _unescaped(read) if "\\" in read and not is_element else read
    if kind.base == "bool":
        if text.lower() not in _BOOLS:
            raise ValueError(f"expected true, false, 1 or 0, not {text[:_SHOWN]}")
        return _BOOLS[text.lower()]
    if kind.base in FLOATS:
        try:
            return float(text)
        except ValueError:
            raise ValueError(f"expected a number, not {text[:_SHOWN]}") from None
    low, high = INTEGERS.get(kind.base, (0, 255))  # The default is a byte's range.
    value = _whole(text)
    if value is None or not low <= value <= high:
        raise ValueError(f"expected a whole number within {low} .. {high}, not {text[:_SHOWN]}")
    return value


def _whole(text: str) -> int | None:
    for base in (10, 0):  # 010 is ten, 0x10 is sixteen.
        try:
            return int(text, base)
        except ValueError:
            continue
    return None


def _text(text: str, bound: int | None) -> str:
    for quote in ('"', "'"):
        if text.startswith(quote) and text.endswith(quote):
            text = text[1:-1]
            if re.search(rf"(?<!\\){quote}", text):
                raise ValueError(f"a {quote} inside is written \\{quote}")
            text = text.replace(f"\\{quote}", quote)
            break
    if bound is not None and len(text) > bound:
        raise ValueError(f"expected at most {bound} characters, not {len(text)}")
    return text


def _unescaped(text: str) -> str:
    r"""Return a text with `\t` and the like decoded, as rosidl does by way of a Latin-1 file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # "\d" stays as written.
            plain = text.encode().decode("unicode_escape")
        return plain.encode("iso-8859-1").decode()
    except UnicodeError:
        raise ValueError(f"an escape that cannot be read: {text[:_SHOWN]}") from None


def _texts(inside: str) -> list[str]:
    found, place = [], 0
    while place < len(inside):
        item = _ELEMENT.match(inside, place)
        if item is None:
            raise ValueError(f"expected texts like 'a', \"b\", not {inside[place:][:_SHOWN]}")
        found.append(next(part for part in item.groups() if part is not None))
        place = item.end()
    return found
