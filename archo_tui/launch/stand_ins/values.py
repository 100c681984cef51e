"""Texts that become values, by the rules of launch, which are YAML 1.1's; and parameters."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, get_args, get_origin

import yaml

from archo_tui.launch.stand_ins.core import (
    Flag,
    LaunchContext,
    Made,
    SubstitutionFailure,
    Text,
    is_substitution,
    normalize_to_list_of_substitutions,
    perform,
)

SCALARS = (bool, int, float, str)


def value_of(context: LaunchContext, given: Any, kind: Any = None) -> Any:
    """Return a value, a text as a value of a type such as `int` or `list[int]`, else as YAML reads.

    Raises ValueError.
    """
    if is_substitution(given):
        return value_of_text(perform(context, given), kind)
    if isinstance(given, SCALARS):
        return given if kind is None else _checked(given, given, kind)
    if not isinstance(given, Iterable):
        raise ValueError(f"a value or a substitution is wanted, not {given!r}")
    values = [
        part if isinstance(part, SCALARS) else value_of(context, part, _element(kind))
        for part in given
    ]
    if {type(value) for value in values} == {int, float}:
        values = [float(value) for value in values]
    return _checked(values, values, kind)


def value_of_text(text: str, kind: Any = None) -> Any:
    """Return a text as a value of a type, else as YAML 1.1 reads it; a bool may be `1` or `0`."""
    if kind is str:
        return text
    try:
        if kind in (int, float):
            return kind(text)
        if kind is bool:  # launch takes these two besides YAML's words.
            text = {"1": "true", "0": "false"}.get(text, text)
        value = yaml.safe_load(text) if text else text
    except (ValueError, yaml.YAMLError):
        raise ValueError(_wanted(text, kind)) from None
    return _checked(value, text, kind)


def _checked(value: Any, given: Any, kind: Any) -> Any:
    """Return a value if it is a scalar, or a list of scalars of one type, as the type says."""
    is_list = isinstance(value, list)
    values = value if is_list else [value]
    wanted = kind if kind in SCALARS else _element(kind) or (type(values[0]) if values else str)
    fits = kind is None or is_list == (kind not in SCALARS)
    if not fits or wanted not in SCALARS or not all(isinstance(v, wanted) for v in values):
        raise ValueError(_wanted(given, kind))
    return value


def _wanted(given: Any, kind: Any) -> str:
    if kind is None:
        return f"{given!r} is no number, boolean, text or list of values of one type"
    return f"{given!r} is not of type {kind.__name__ if kind in SCALARS else kind}"


def _element(kind: Any) -> Any:
    """Return `int` for the type `list[int]`, and None if any value will do."""
    return get_args(kind)[0] if get_origin(kind) is list else None


def flag(context: LaunchContext, given: Flag) -> bool:
    """Return the bool that something stands for."""
    return bool(value_of(context, given, bool))


def number(context: LaunchContext, given: Any) -> float:
    """Return the float that something stands for."""
    return float(value_of(context, given, float))


@dataclass(eq=False)
class ParameterValue(Made):
    """The value of a parameter, and the type that its text is to become.

    Without a type, the text of a substitution is read as YAML 1.1; a plain text stays one.
    """

    value: Any
    _: KW_ONLY
    value_type: Any = None

    def evaluate(self, context: LaunchContext) -> Any:
        """Return the value with its substitutions performed; raise SubstitutionFailure."""
        try:
            return value_of(context, self.value, self.value_type)
        except ValueError as error:
            raise SubstitutionFailure(error, self.place) from None


class Parameter(ParameterValue):
    """A parameter by its name and value, and the type that its text is to become."""

    def __init__(self, name: Text, value: Any, *, value_type: Any = None) -> None:
        super().__init__(value, value_type=value_type)
        self.name = normalize_to_list_of_substitutions(name)


@dataclass(eq=False)
class ParameterFile(Made):
    """A parameter file; `allow_substs` tells that `$(var name)` in it is to be replaced.

    Here nothing is replaced: a Node leaves such a file out, with a note, if it has a `$(`.
    """

    param_file: Text
    _: KW_ONLY
    allow_substs: Flag = False

    def evaluate(self, context: LaunchContext) -> str:
        """Return the absolute path of the file, which need not exist."""
        return os.path.abspath(perform(context, self.param_file))


def evaluate_parameters(
    context: LaunchContext, given: Mapping[Any, Any], prefix: str = ""
) -> dict[str, Any]:
    """Return the parameters of a mapping by their full names: `{"pid": {"p": 1}}` is `pid.p`.

    Substitutions are performed, and their texts read as YAML 1.1, as launch_ros does.
    """
    found: dict[str, Any] = {}
    for key, value in given.items():
        name = prefix + perform(context, key)
        if isinstance(value, Mapping):
            found |= evaluate_parameters(context, value, f"{name}.")
        else:
            found[name] = _evaluate(context, name, value)
    return found


def _evaluate(context: LaunchContext, name: str, value: Any) -> Any:
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    if isinstance(value, bytes):
        return value
    try:
        found = value_of(context, value)
    except ValueError as error:
        hint = "is a text meant? ParameterValue(..., value_type=str)"
        raise TypeError(f"parameter {name}: {error}: {hint}") from None
    if found == []:
        raise TypeError(f"parameter {name}: the list {found!r} is empty, so its type is not known")
    return found
