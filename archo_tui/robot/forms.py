"""What is typed into a form, as values of a message's fields. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import yaml

from archo_tui.robot.state import Leaf
from archo_tui.robot.values import parse_bool, parse_integer, parse_number, text_of
from archo_tui.robots.model import Input

_INTEGER = re.compile(r"(u?)int(8|16|32|64)")
_ARRAY = re.compile(r"sequence<(.+?)(?:, *\d+)?>|(.+)\[\d+\]")
_SHOWN = 20  # characters of a wrong text that are shown
_LONGEST = 10_000  # characters of a typed value
_FARTHEST = 10**30  # beyond every type's range, which is said by itself


def is_integer(leaf: Leaf) -> bool:
    """True for a field that takes whole numbers only."""
    return _INTEGER.fullmatch(leaf.type) is not None or leaf.type in ("byte", "char", "octet")


def is_number(leaf: Leaf) -> bool:
    """True for a field that takes numbers only."""
    return is_integer(leaf) or leaf.type in ("float", "double")


def is_list(leaf: Leaf) -> bool:
    """True for a field that takes a list."""
    return "sequence<" in leaf.type or leaf.type.endswith("]")


def range_of(leaf: Leaf) -> tuple[int, int] | None:
    """What a whole number of the field's type may be."""
    found = _INTEGER.fullmatch(leaf.type)
    if found is None:
        return (0, 255) if is_integer(leaf) else None
    bits = int(found[2])
    return (0, 2**bits - 1) if found[1] else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def parse(leaf: Leaf, given: Input, text: str) -> Any:
    """The value that was typed for a field. Raises ValueError with one line that says why not."""
    label = given.label or leaf.path
    shown = text.strip() if len(text) <= _SHOWN else f"{text.strip()[:_SHOWN]} ..."
    if not text.strip() and "string" not in leaf.type:
        raise ValueError(f"{label}: type a value")
    try:
        value = _value(leaf, text)
    except ValueError:
        kinds = "true or false" if leaf.type == "boolean" else "a number"
        kinds = "a whole number" if is_integer(leaf) else "a list" if is_list(leaf) else kinds
        raise ValueError(f"{label}: not {kinds}: {shown}") from None
    whole = range_of(leaf)
    low = given.low if given.low is not None or whole is None else whole[0]
    high = given.high if given.high is not None or whole is None else whole[1]
    if not is_number(leaf):  # a range of it is said where the file is checked
        return value
    if low is not None and value < low:
        raise ValueError(f"{label}: at least {low:.15g}, not {shown}")
    if high is not None and value > high:
        raise ValueError(f"{label}: at most {high:.15g}, not {shown}")
    return value


def parse_all(
    leaves: Iterable[Leaf], form: Mapping[str, Input], texts: Mapping[str, str]
) -> dict[str, Any]:
    """All values by dotted path; raises ValueError for the first that is wrong."""
    return {
        leaf.path: parse(leaf, form.get(leaf.path, Input()), texts[leaf.path]) for leaf in leaves
    }


def named(leaves: Iterable[Leaf], form: Mapping[str, Input], words: list[str]) -> dict[str, str]:
    """The texts of `x=1.5 y=2`, or of a form with one field of `12`, by dotted path.

    Raises ValueError with one line that says what was expected.
    """
    labels = {(form.get(leaf.path, Input()).label or leaf.path): leaf.path for leaf in leaves}
    if len(labels) == 1 and not any("=" in word for word in words):
        return {path: " ".join(words) for path in labels.values()}
    lower = {label.lower(): path for label, path in labels.items()}
    found = {}
    for word in words:
        name, equals, text = word.partition("=")
        path = lower.get(name.lower())
        if not equals or path is None:
            raise ValueError(f"expected {_expected(labels)}, not {word[:_SHOWN]}")
        found[path] = text
    if set(found) != set(lower.values()):
        raise ValueError(f"expected {_expected(labels)}" if labels else "takes nothing")
    return found


def _expected(labels: Iterable[str]) -> str:
    return " ".join(f"{label.lower()}=..." for label in labels) or "nothing"


def _value(leaf: Leaf, text: str) -> Any:
    if len(text) > _LONGEST:
        raise ValueError
    if is_list(leaf):
        return _list(leaf, text)
    if "string" in leaf.type:
        return text
    stripped = text.strip()
    if leaf.type == "boolean":
        return parse_bool(stripped)
    if is_integer(leaf):
        return parse_integer(stripped, -_FARTHEST, _FARTHEST)
    return parse_number(stripped)


def _list(leaf: Leaf, text: str) -> list[Any]:
    found = _ARRAY.fullmatch(leaf.type)
    element = leaf._replace(type="" if found is None else found[1] or found[2])
    # YAML has numbers of its own, such as 1_2 and 1:30
    loader = yaml.BaseLoader if is_number(element) else yaml.SafeLoader
    try:
        items = yaml.load(text, Loader=loader)
    except yaml.YAMLError:
        items = None
    if not isinstance(items, list):
        raise ValueError
    return [_value(element, text_of(item)) for item in items] if is_number(element) else items


def default_text(leaf: Leaf) -> str:
    """What stands in the field at first."""
    return text_of(leaf.default) if isinstance(leaf.default, (int, float, str, list)) else ""
