"""Texts that become values, by the rules of launch, which are YAML 1.1's; and parameters."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin

import yaml

from archo_tui.launch.stand_ins.core import (
    LaunchContext,
    SomeSubstitutionsType,
    Substitution,
    SubstitutionFailure,
    calling_place,
    is_substitution,
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)

__all__ = [
    "Parameter",
    "ParameterFile",
    "ParameterValue",
]

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


_AS_TEXT = "is a text meant? ParameterValue(..., value_type=str)"


class ParameterValue:
    """The value of a parameter, and the type that its text is to become.

    Without a type, the text of a substitution is read as YAML 1.1; a plain text stays one.
    """

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        check_typed(value, value_type)
        self.place = calling_place()
        self.value, self.value_type = value, value_type

    def evaluate(self, context: LaunchContext) -> Any:
        """Return the value with its substitutions performed; raise SubstitutionFailure."""
        try:
            return perform_typed(context, self.value, self.value_type)
        except ValueError as error:
            raise SubstitutionFailure(error, self.place) from None


class Parameter:
    """A parameter by its name and value, and the type that its text is to become."""

    def __init__(self, name: SomeSubstitutionsType, value: Any, *, value_type: Any = None) -> None:
        self.name = normalize_to_list_of_substitutions(name)
        self._value = ParameterValue(value, value_type=value_type)

    def evaluate(self, context: LaunchContext) -> tuple[str, Any]:
        """Return the name and the value, with their substitutions performed."""
        return perform_substitutions(context, self.name), self._value.evaluate(context)


class ParameterFile:
    """A parameter file; `allow_substs` tells that `$(var name)` in it is to be replaced.

    Here nothing is replaced: a Node leaves such a file out, with a note, if it has a `$(`.
    """

    def __init__(
        self,
        param_file: SomeSubstitutionsType,
        *,
        allow_substs: bool | SomeSubstitutionsType = False,
    ) -> None:
        check_typed(allow_substs, bool)
        self.place = calling_place()
        self._path = normalize_to_list_of_substitutions(param_file)
        self._allow_substs = allow_substs

    def evaluate(self, context: LaunchContext) -> str:
        """Return the absolute path of the file, which need not exist."""
        return os.path.abspath(perform_substitutions(context, self._path))

    def is_substituted(self, context: LaunchContext) -> bool:
        return bool(perform_typed(context, self._allow_substs, bool))


def evaluate_parameters(context: LaunchContext, given: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the parameters of a mapping by their full names: `{"pid": {"p": 1}}` is `pid.p`.

    Substitutions are performed, and their texts read as YAML 1.1, as launch_ros does.
    """
    return {name: _evaluate(context, name, value) for name, value in _flat(context, given, "")}


def _flat(
    context: LaunchContext, given: Mapping[Any, Any], prefix: str
) -> Iterator[tuple[str, Any]]:
    for key, value in given.items():
        name = prefix + perform(context, key)
        if isinstance(value, Mapping):
            yield from _flat(context, value, f"{name}.")
        else:
            yield name, value


def _evaluate(context: LaunchContext, name: str, value: Any) -> Any:
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    if isinstance(value, bytes):
        return value
    if not isinstance(value, (*SCALARS, Substitution, Sequence)):
        raise TypeError(f"parameter {name} is {value!r}, which no parameter can be")
    try:
        found = perform_typed(context, value, None)
    except ValueError as error:
        raise TypeError(f"parameter {name}: {error}: {_AS_TEXT}") from None
    if found == []:
        raise TypeError(f"parameter {name}: the list {found!r} is empty, so its type is not known")
    return found
