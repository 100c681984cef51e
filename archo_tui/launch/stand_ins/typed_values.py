"""Texts that become numbers, booleans or lists by the rules of launch, which are YAML 1.1's."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, get_args, get_origin

import yaml

from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.substitution import (
    is_substitution,
    normalize_to_list_of_substitutions,
    perform,
)

SCALARS = (bool, int, float, str)


def check_typed(given: Any, value_type: Any) -> None:
    """Raise TypeError for what can never become a value of a type, as launch does.

    The texts of substitutions are not known yet, so they are not checked. An int is no float, but a
    bool is an int.
    """
    scalar, is_list = parts_of(value_type)
    if isinstance(given, SCALARS):
        if value_type is not None and (is_list or not isinstance(given, scalar)):
            raise TypeError(f"{given!r} is not of type {_name(value_type)}")
    elif not is_substitution(given):
        if not isinstance(given, Iterable):
            raise TypeError(f"a value or a substitution is wanted, not {given!r}")
        if value_type is not None and not is_list:
            raise TypeError(f"{given!r} is a list, and {_name(value_type)} is wanted")
        for part in given:
            if not isinstance(part, SCALARS) and not is_substitution(part):
                raise TypeError(f"{part!r} in a list is neither a value nor a substitution")


def perform_typed(context: LaunchContext, given: Any, value_type: Any) -> Any:
    """Return the value that a substitution, or a list of them, stands for; raise ValueError."""
    if isinstance(given, SCALARS):
        return given
    if is_substitution(given):
        return typed_text(perform(context, given), value_type)
    scalar, _ = parts_of(value_type)
    wanted = None if value_type is None else scalar
    values = [
        typed_text(perform_part(context, part), wanted) if is_substitution(part) else part
        for part in given
    ]
    if {type(value) for value in values} == {int, float} and wanted in (None, float):
        return [float(value) for value in values]
    if not is_uniform(values, wanted):
        raise ValueError(f"a list of values of one type is wanted, not {values!r}")
    return values


def perform_part(context: LaunchContext, part: Any) -> str:
    """Return the text of one element of a list, which may itself be a list of texts to join."""
    return "".join(p.perform(context) for p in normalize_to_list_of_substitutions(part))


def typed_text(text: str, value_type: Any) -> Any:
    """Return a text as a value of a type, read as YAML 1.1; a bool may also be `1` or `0`."""
    scalar, is_list = parts_of(value_type)
    if value_type is str:
        return text
    if value_type in (int, float):
        try:
            return scalar(text)
        except ValueError:
            raise ValueError(f"{text!r} is not of type {_name(value_type)}") from None
    if value_type is bool:  # launch takes these two besides YAML's words.
        text = {"1": "true", "0": "false"}.get(text, text)
    value = _yaml_value(text)
    fits = isinstance(value, bool) if value_type is bool else not is_list or _is_list(value, scalar)
    if not fits:
        raise ValueError(f"{text!r} is not of type {_name(value_type)}")
    return value


def is_uniform(values: list[Any], value_type: Any = None) -> bool:
    """Return True if all values are of one type, by default the first's; a bool is an int."""
    wanted = value_type or (type(values[0]) if values else str)
    return wanted in SCALARS and all(isinstance(value, wanted) for value in values)


def _yaml_value(text: str) -> Any:
    if not text:
        return text
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        raise ValueError(f"{text!r} is not YAML") from None
    if not isinstance(value, SCALARS) and not (isinstance(value, list) and is_uniform(value)):
        raise ValueError(
            f"{text!r} is neither a number, a boolean, a text nor a list of values of one type"
        )
    return value


def _is_list(value: Any, of: Any) -> bool:
    return isinstance(value, list) and all(isinstance(part, of) for part in value)


def parts_of(value_type: Any) -> tuple[Any, bool]:
    """Split a type such as `List[int]`: return `int`, and True for a list."""
    is_list = get_origin(value_type) is list
    scalar = get_args(value_type)[0] if is_list else value_type
    if scalar is not None and scalar not in SCALARS:
        raise ValueError(f"no value_type {value_type!r}: bool, int, float, str or a List of one")
    return scalar, is_list


def _name(value_type: Any) -> str:
    scalar, is_list = parts_of(value_type)
    return f"List[{scalar.__name__}]" if is_list else str(scalar.__name__)
