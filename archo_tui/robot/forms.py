"""What is typed into a form, as values of a message's fields. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from archo_tui.robot.fields import INTEGERS, checked, element_of
from archo_tui.robot.parameter_values import typed_text
from archo_tui.robot.state import Leaf
from archo_tui.robot.values import (
    parse_any_number,
    parse_bool,
    parse_integer,
    text_of,
)
from archo_tui.robot_file.model import FormField, Limit, ParameterRef
from archo_tui.yaml_text import bounded_yaml
from archo_tui.yaml_text.core_schema import YamlFault

_SHOWN = 20  # characters of a wrong text that are shown
_LONGEST = 10_000  # characters of a typed value
_FARTHEST = 10**30  # beyond every type's range, which is said by itself


def is_integer(leaf: Leaf) -> bool:
    """True for a field that takes whole numbers only."""
    return leaf.type in INTEGERS


def is_number(leaf: Leaf) -> bool:
    """True for a field that takes numbers only."""
    return is_integer(leaf) or leaf.type in ("float", "double")


def is_list(leaf: Leaf) -> bool:
    """True for a field that takes a list."""
    return element_of(leaf.type) is not None


def parse(leaf: Leaf, given: FormField, text: str) -> Any:
    """The value that was typed for a field. Raises ValueError with one line that says why not."""
    label = given.label or leaf.path
    shown = text.strip() if len(text) <= _SHOWN else f"{text.strip()[:_SHOWN]} ..."
    if not text.strip() and "string" not in leaf.type:
        raise ValueError(f"{label}: type a value")
    if len(text) > _LONGEST:
        raise ValueError(f"{label}: {len(text)} characters, at most {_LONGEST}")
    try:
        value = _value(leaf, text)
    except YamlFault as fault:
        raise ValueError(f"{label}: {fault.reason}: {shown}") from None
    except ValueError:
        kinds = "true or false" if leaf.type == "boolean" else "a number"
        kinds = "a whole number" if is_integer(leaf) else "a list" if is_list(leaf) else kinds
        raise ValueError(f"{label}: not {kinds}: {shown}") from None
    if is_number(leaf):  # a range of another one is said where the file is checked
        check_range(leaf, given, value, shown)
    checked(leaf.type, value, label)
    return value


def check_range(leaf: Leaf, given: FormField, value: Any, shown: str) -> None:
    """Raises ValueError for a number that is not within the limits of a field, as far as known."""
    label = given.label or leaf.path
    low, high = INTEGERS.get(leaf.type, (None, None))
    low, high = _known(given.low, low), _known(given.high, high)
    # written so that nan, which is not less than anything, is not in a range either
    if low is not None and not value >= low:
        raise ValueError(f"{label}: at least {low:.15g}, not {shown}")
    if high is not None and not value <= high:
        raise ValueError(f"{label}: at most {high:.15g}, not {shown}")
    if given.convert and not math.isfinite(value):
        raise ValueError(f"{label}: not a finite number: {shown}")


def check_ranges(
    leaves: Iterable[Leaf], form: Mapping[str, FormField], values: Mapping[str, Any]
) -> None:
    """As `check_range`, of every number among the values by dotted path."""
    for leaf in filter(is_number, leaves):
        value = values[leaf.path]
        check_range(leaf, form.get(leaf.path, FormField()), value, text_of(value))


def _known(given: Limit, otherwise: float | None) -> float | None:
    """A limit of the robot file; a link to a number that nobody reports limits nothing."""
    return otherwise if given is None or isinstance(given, ParameterRef) else given


def parse_all(
    leaves: Iterable[Leaf], form: Mapping[str, FormField], texts: Mapping[str, str]
) -> dict[str, Any]:
    """All values by dotted path; raises ValueError for the first that is wrong."""
    return {
        leaf.path: parse(leaf, form.get(leaf.path, FormField()), texts[leaf.path])
        for leaf in leaves
    }


def named(
    leaves: Iterable[Leaf], form: Mapping[str, FormField], words: list[str]
) -> dict[str, str]:
    """The texts of `x=1.5 y=2`, or of a form with one field of `12`, by dotted path.

    Raises ValueError with one line that says what was expected.
    """
    labels = {(form.get(leaf.path, FormField()).label or leaf.path): leaf.path for leaf in leaves}
    if len(labels) == 1 and not any("=" in word for word in words):
        return {path: " ".join(words) for path in labels.values()}
    lower = {path.lower(): path for path in labels.values()}
    lower |= {label.lower(): path for label, path in labels.items()}
    found = {}
    if words and not labels:
        raise ValueError("takes no values")
    for word in words:
        name, equals, text = word.partition("=")
        path = lower.get(name.lower())
        if not equals or path is None or path in found:
            raise ValueError(f"expected {_expected(labels)}, not {word[:_SHOWN]}")
        found[path] = text
    if set(found) != set(labels.values()):
        raise ValueError(f"expected {_expected(labels)}" if labels else "takes no values")
    return found


def _expected(labels: Iterable[str]) -> str:
    return " ".join(f"{label.lower()}=..." for label in labels) or "nothing"


def _value(leaf: Leaf, text: str) -> Any:
    element = element_of(leaf.type)
    if element is not None:
        return _list(leaf._replace(type=element), text)
    if "string" in leaf.type:
        return text
    stripped = text.strip()
    if leaf.type == "boolean":
        return parse_bool(stripped)
    if is_integer(leaf):
        return parse_integer(stripped, -_FARTHEST, _FARTHEST)
    return parse_any_number(stripped)


def _list(element: Leaf, text: str) -> list[Any]:
    """What each element means its type says, as for a field of one; of messages YAML does."""
    if "/" not in element.type:
        return [_value(element, item) for item in bounded_yaml.scalar_texts(text)]
    items = bounded_yaml.load(text)
    if not isinstance(items, list):
        raise ValueError
    return items


def default_text(leaf: Leaf) -> str:
    """What stands in the field at first: it means the value that the message has by itself."""
    return typed_text(leaf.default)
