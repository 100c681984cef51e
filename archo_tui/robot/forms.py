"""The parsing of texts that are typed into a form, by the types of a message's fields."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from archo_tui.robot.fields import checked, element_of
from archo_tui.robot.parameter_values import typed_text
from archo_tui.robot.state import TypedField
from archo_tui.robot.values import (
    INTEGERS,
    parse_any_number,
    parse_bool,
    parse_integer,
    text_of,
)
from archo_tui.robot_file.model import FormField, Limit, ParameterRef
from archo_tui.yaml_text import bounded_yaml
from archo_tui.yaml_text.core_schema import YamlFault

_SHOWN = 20  # Characters of a wrong text that its error quotes.
_LONGEST = 10_000  # Characters of a typed value.
_FARTHEST = 10**30  # Beyond the range of every type, which is checked separately.


def is_integer(field: TypedField) -> bool:
    """Return True for a field of an integer type; arrays of integers are none."""
    return field.type in INTEGERS


def is_number(field: TypedField) -> bool:
    """Return True for a field of an integer or float type; arrays of numbers are none."""
    return is_integer(field) or field.type in ("float", "double")


def is_list(field: TypedField) -> bool:
    """Return True for a field that is an array."""
    return element_of(field.type) is not None


def parse(field: TypedField, given: FormField, text: str) -> Any:
    """Return the value that a typed text stands for, checked against the field's type and limits.

    Args:
        field: The field.
        given: The label and limits of the field in the robot file. Limits that are parameters are
            not checked.
        text: What was typed; for a string, all of it; for an array, a list as YAML has it.

    Raises:
        ValueError: In one line, with the label, why the text is no value for the field: also if it
            is longer than 10,000 characters, or blank and the field no string.
    """
    label = given.label or field.path
    shown = text.strip() if len(text) <= _SHOWN else f"{text.strip()[:_SHOWN]} ..."
    if not text.strip() and "string" not in field.type:
        raise ValueError(f"{label}: type a value")
    if len(text) > _LONGEST:
        raise ValueError(f"{label}: {len(text)} characters, at most {_LONGEST}")
    try:
        value = _value(field, text)
    except YamlFault as fault:
        raise ValueError(f"{label}: {fault.reason}: {shown}") from None
    except ValueError:
        kinds = "true or false" if field.type == "boolean" else "a number"
        kinds = "a whole number" if is_integer(field) else "a list" if is_list(field) else kinds
        raise ValueError(f"{label}: not {kinds}: {shown}") from None
    if is_number(field):  # The check of the file reports a range for another type.
        check_range(field, given, value, shown)
    checked(field.type, value, label)
    return value


def check_range(field: TypedField, given: FormField, value: Any, shown: str) -> None:
    """Raise ValueError if a number is outside the limits of a field.

    The limits are those of the robot file, except those that are parameters, and those of an
    integer type. A value that is converted, as a yaw, must be finite, too.

    Args:
        field: The field.
        given: The label and limits of the field in the robot file.
        value: The number.
        shown: The number as an error quotes it.

    Raises:
        ValueError: In one line, with the label, which limit is exceeded.
    """
    label = given.label or field.path
    low, high = INTEGERS.get(field.type, (None, None))
    low, high = _number_of(given.low, low), _number_of(given.high, high)
    # In this form the comparison also refuses NaN.
    if low is not None and not value >= low:
        raise ValueError(f"{label}: at least {low:.15g}, not {shown}")
    if high is not None and not value <= high:
        raise ValueError(f"{label}: at most {high:.15g}, not {shown}")
    if given.convert and not math.isfinite(value):
        raise ValueError(f"{label}: not a finite number: {shown}")


def check_ranges(
    fields: Iterable[TypedField], form: Mapping[str, FormField], values: Mapping[str, Any]
) -> None:
    """Raise ValueError for the first number that is outside the limits of its field.

    Args:
        fields: The fields; those that are no numbers are not checked.
        form: The labels and limits in the robot file, by dotted path.
        values: The value of every field, by dotted path.

    Raises:
        ValueError: As in `check_range`.
    """
    for field in filter(is_number, fields):
        value = values[field.path]
        check_range(field, form.get(field.path, FormField()), value, text_of(value))


def _number_of(given: Limit, otherwise: float | None) -> float | None:
    """Return a limit as a number.

    Returns:
        The number of the robot file; `otherwise` if it gives none, or refers to a parameter.
    """
    return otherwise if given is None or isinstance(given, ParameterRef) else given


def parse_all(
    fields: Iterable[TypedField], form: Mapping[str, FormField], texts: Mapping[str, str]
) -> dict[str, Any]:
    """Return the values of the fields that have a text, by dotted path; other fields are left out.

    Args:
        fields: The fields.
        form: The labels and limits in the robot file, by dotted path.
        texts: What was typed, by dotted path.

    Raises:
        ValueError: Why the first wrong text is no value.
    """
    return {
        field.path: parse(field, form.get(field.path, FormField()), texts[field.path])
        for field in fields
        if field.path in texts
    }


def texts_by_path(
    fields: Iterable[TypedField],
    form: Mapping[str, FormField],
    words: Sequence[str],
    *,
    partial: bool = False,
) -> dict[str, str]:
    """Return the texts in words such as `x=1.5 y=2`, by dotted path; nothing is parsed yet.

    For a single field, words of which none has a `=` are its text. Names are matched in any case.

    Args:
        fields: The fields.
        form: The labels in the robot file, by dotted path.
        words: The words: a label or a path, `=`, and the text.
        partial: True to let words leave fields out; a text without its name is then refused.

    Raises:
        ValueError: In one line what was expected: a name is unknown, is given twice, or is missing.
    """
    labels = {
        (form.get(field.path, FormField()).label or field.path): field.path for field in fields
    }
    if not partial and len(labels) == 1 and not any("=" in word for word in words):
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
    if not partial and set(found) != set(labels.values()):
        raise ValueError(f"expected {_expected(labels)}" if labels else "takes no values")
    return found


def _expected(labels: Iterable[str]) -> str:
    return " ".join(f"{label.lower()}=..." for label in labels) or "nothing"


def _value(field: TypedField, text: str) -> Any:
    element = element_of(field.type)
    if element is not None:
        return _list(field._replace(type=element), text)
    if "string" in field.type:
        return text
    stripped = text.strip()
    if field.type == "boolean":
        return parse_bool(stripped)
    if is_integer(field):
        return parse_integer(stripped, (-_FARTHEST, _FARTHEST))
    return parse_any_number(stripped)


def _list(element: TypedField, text: str) -> list[Any]:
    """Parse a list: each element by the type of the elements, messages as YAML."""
    if "/" not in element.type:
        return [_value(element, item) for item in bounded_yaml.scalar_texts(text)]
    items = bounded_yaml.load(text)
    if not isinstance(items, list):
        raise ValueError
    return items


def default_text(field: TypedField, given: FormField) -> str:
    """Return the text that a form shows in a field at first: the default value of the message.

    Args:
        field: The field.
        given: The label and limits of the field in the robot file.

    Returns:
        The text; "" for a number that is outside the limits.
    """
    text = typed_text(field.default)
    if is_number(field):
        try:
            check_range(field, given, field.default, text)
        except ValueError:
            return ""
    return text


def range_text(given: FormField) -> str:
    """Return the limits in the robot file: `1 .. 40`, `at least 1`, `at most 40`, or "".

    A limit that is a parameter is left out.
    """
    low, high = _number_of(given.low, None), _number_of(given.high, None)
    if low is not None and high is not None:
        return f"{low:.15g} .. {high:.15g}"
    if high is not None:
        return f"at most {high:.15g}"
    return "" if low is None else f"at least {low:.15g}"
