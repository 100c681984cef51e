"""The parsing of typed texts by the types of fields, as rosidl writes them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.base.yaml_text.core_schema import YamlFault
from archo_tui.base.yaml_text.dump import flow
from archo_tui.robot.messages.types import INTEGERS, TypedField, element_of
from archo_tui.robot.messages.values import checked, text_of
from archo_tui.robot_file.model import FormField, Limit, ParameterRef, Scalar

# Stricter than int() and float(), which also accept `1_2` and the digits of every script.
_WHOLE = re.compile(r"[+-]?[0-9]+")
_NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")
_INFINITE = re.compile(r"[+-]?\.?(inf|Inf|INF)|\.?(nan|NaN|NAN)")  # YAML's dot is optional.
_DIGITS = 30  # More than any type has; further digits cannot make a number fit.
_BOOLS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}

MAX_LENGTH = 10_000  # Characters of a typed value.
_SHOWN = 20  # Characters of a wrong text that its error quotes.
_FARTHEST = 10**30  # Beyond the range of every type, which is checked separately.

Request = Mapping[str, Scalar]  # The values of a request by field, as in the robot file.
_TYPES = {bool: "boolean", int: "int64", float: "double", str: "string"}


def parse_bool(text: str) -> bool:
    """Return the bool that true, yes, on, false, no or off means; else raise ValueError."""
    if text.lower() not in _BOOLS:
        raise ValueError(f"not true or false: {text}")
    return _BOOLS[text.lower()]


def parse_integer(text: str, limits: tuple[int, int] = INTEGERS["int64"]) -> int:
    """Return the whole number in decimal digits with an optional sign; else raise ValueError."""
    stripped = text.strip()
    if not _WHOLE.fullmatch(stripped):
        raise ValueError(f"not a whole number: {text}")
    value = int(stripped.lstrip("+-0")[:_DIGITS] or "0")
    value = -value if stripped.startswith("-") else value
    if not limits[0] <= value <= limits[1]:
        raise ValueError(f"too large for an integer: {text}")
    return value


def parse_number(text: str) -> float:
    """Return the finite number in a text, such as `-1.5` or `2e3`; else raise ValueError."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"not a number: {text}") from None
    if not math.isfinite(value):
        raise ValueError(f"not a finite number: {text}")
    if not _NUMBER.fullmatch(text.strip()):
        raise ValueError(f"not a number: {text}")
    return value


def parse(kind: str, text: str, *, of_parameter: bool = False) -> Any:
    """Return the value that a text stands for, by the type of its field; an array is a YAML list.

    A parameter's infinity needs YAML's dot, as in a file. Raises ValueError, or YamlFault for a
    list.
    """
    element = element_of(kind)
    if element is not None and "/" in element:
        items = bounded_yaml.load(text)
        if not isinstance(items, list):
            raise ValueError("not a list")
        return items
    if element is not None:  # The items are texts, since their type is declared.
        items = bounded_yaml.scalar_texts(text)
        return [parse(element, item, of_parameter=of_parameter) for item in items]
    if "string" in kind:
        return text
    stripped = text.strip()
    if kind == "boolean":
        return parse_bool(stripped)
    if kind in INTEGERS:
        limits = INTEGERS["int64"] if of_parameter else (-_FARTHEST, _FARTHEST)
        return parse_integer(stripped, limits)
    if _INFINITE.fullmatch(stripped) and (not of_parameter or "." in stripped):
        return float(stripped.replace(".", ""))
    return parse_number(stripped)


def typed_text(value: Any) -> str:
    """Return a value as text for an input field, which `parse` turns back into it."""
    if isinstance(value, str):
        return value
    return flow(value) if isinstance(value, list) else text_of(value)


def is_integer(field: TypedField) -> bool:
    """Return True for a field of an integer type; arrays of integers are none."""
    return field.type in INTEGERS


def is_number(field: TypedField) -> bool:
    """Return True for a field of an integer or float type; arrays of numbers are none."""
    return is_integer(field) or field.type in ("float", "double")


def parse_field(field: TypedField, given: FormField, text: str) -> Any:
    """Return the value of a typed text that fits field and robot file; else raise ValueError."""
    label = given.label or field.path
    shown = text.strip() if len(text) <= _SHOWN else f"{text.strip()[:_SHOWN]} ..."
    if not text.strip() and "string" not in field.type:
        raise ValueError(f"{label}: type a value")
    if len(text) > MAX_LENGTH:
        raise ValueError(f"{label}: {len(text)} characters, at most {MAX_LENGTH}")
    try:
        value = parse(field.type, text)
    except YamlFault as fault:
        raise ValueError(f"{label}: {fault.reason}: {shown}") from None
    except ValueError:
        what = "true or false" if field.type == "boolean" else "a number"
        what = "a whole number" if is_integer(field) else what
        what = what if element_of(field.type) is None else "a list"
        raise ValueError(f"{label}: not {what}: {shown}") from None
    if is_number(field):  # The check of the file reports a range for another type.
        check_range(field, given, value, shown)
    checked(field.type, value, label)
    return value


def check_range(field: TypedField, given: FormField, value: Any, shown: str) -> None:
    """Raise ValueError if a number is outside the limits of its type, or of the robot file."""
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
    """Raise ValueError for the first number, by dotted path, outside the limits of its field."""
    for field in filter(is_number, fields):
        value = values[field.path]
        check_range(field, form.get(field.path, FormField()), value, text_of(value))


def _number_of(given: Limit, otherwise: float | None) -> float | None:
    return otherwise if given is None or isinstance(given, ParameterRef) else given


class FieldError(ValueError):
    """The error that the text of the field with this path is not valid; its message says why."""

    def __init__(self, text: str, path: str) -> None:
        super().__init__(text)
        self.path = path


def parse_all(
    fields: Iterable[TypedField], form: Mapping[str, FormField], texts: Mapping[str, str]
) -> dict[str, Any]:
    """Return the values of the fields that have a text, by dotted path, or raise FieldError."""
    values = {}
    for field in fields:
        if field.path in texts:
            given = form.get(field.path, FormField())
            try:
                values[field.path] = parse_field(field, given, texts[field.path])
            except ValueError as error:
                raise FieldError(str(error), field.path) from None
    return values


def texts_by_path(
    fields: Iterable[TypedField],
    form: Mapping[str, FormField],
    words: Sequence[str],
    *,
    partial: bool = False,
) -> dict[str, str]:
    """Return the texts in words such as `x=1.5 y=2`, by dotted path; labels stand for paths, too.

    For a single field, words of which none has a `=` are its text, unless they are `partial`.
    Raises ValueError.
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


def default_text(field: TypedField, given: FormField) -> str:
    """Return the text that a form shows in a field at first; "" for a number outside the limits."""
    text = typed_text(field.default)
    if is_number(field):
        try:
            check_range(field, given, field.default, text)
        except ValueError:
            return ""
    return text


def range_text(given: FormField) -> str:
    """Return the limits in the robot file: `1 .. 40`, `at least 1`, `at most 40`, or ""."""
    low, high = _number_of(given.low, None), _number_of(given.high, None)
    if low is not None and high is not None:
        return f"{low:.15g} .. {high:.15g}"
    if high is not None:
        return f"at most {high:.15g}"
    return "" if low is None else f"at least {low:.15g}"


def mapping(text: str) -> dict[str, Any]:
    """Return the values in a YAML mapping `{field: value, ...}`; else raise ValueError."""
    try:
        values = bounded_yaml.load(text)
    except YamlFault as fault:
        raise ValueError(str(fault)) from None
    if not isinstance(values, dict):
        raise ValueError("expected {field: value, ...}")
    return values


def typed_request(service: str, words: Sequence[str], example: Request) -> dict[str, Any]:
    """Return the values that were typed as `field=value ...` or as one YAML mapping."""
    fields = [TypedField(name, _TYPES[type(value)], None) for name, value in example.items()]
    if len(words) == 1 and words[0].startswith("{"):
        words = [f"{name}={value}" for name, value in mapping(words[0]).items()]
    try:
        texts = texts_by_path(fields, {}, words, partial=True)
    except ValueError as error:
        raise ValueError(f"{service}: {error}") from None
    return parse_all(fields, {}, texts)


def as_typed(request: Request) -> str:
    """Return a request of the robot file as an operator types it: `a=true b=2`; texts unquoted."""
    texts = {name: str(v).lower() if isinstance(v, bool) else v for name, v in request.items()}
    return " ".join(f"{name}={text}" for name, text in texts.items())
