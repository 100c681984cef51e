"""The parameters of a node, as `launch_ros` types them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml

from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.failures import SubstitutionFailure
from archo_tui.launch.stand_ins.places import calling_place
from archo_tui.launch.stand_ins.substitution import (
    SomeSubstitutionsType,
    Substitution,
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)
from archo_tui.launch.stand_ins.typed_values import (
    check_typed,
    is_uniform,
    perform_part,
    perform_typed,
)

__all__ = ["Parameter", "ParameterFile", "ParameterValue"]

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
    if isinstance(value, Substitution):
        return _parse_yaml(name, value.perform(context))
    if isinstance(value, (bool, int, float, str, bytes)):
        return value
    if isinstance(value, Sequence):
        return _evaluate_list(context, name, value)
    raise TypeError(f"parameter {name} is {value!r}, which no parameter can be")


def _evaluate_list(context: LaunchContext, name: str, values: Sequence[Any]) -> Any:
    kinds = {type(value) for value in values}
    if kinds == {int, float}:
        return [float(value) for value in values]
    # A list with a substitution is one text: `[LaunchConfiguration("robot"), "/base"]`.
    of_text = all(isinstance(value, (str, Substitution)) for value in values)
    if of_text and any(isinstance(value, Substitution) for value in values):
        return _parse_yaml(name, perform(context, values))
    found = [
        value
        if isinstance(value, (bool, int, float, str))
        else _parse_yaml(name, perform_part(context, value))
        for value in values
    ]
    if not found or not is_uniform(found):
        what = "of different types" if found else "empty, so its type is not known"
        raise TypeError(f"parameter {name}: the list {found!r} is {what}")
    return found


def _parse_yaml(name: str, text: str) -> Any:
    """Parse the text of a parameter as YAML 1.1; TypeError if no parameter can be that."""
    try:
        value = yaml.safe_load(text or "''")
    except yaml.YAMLError:
        raise TypeError(f"parameter {name}: {text!r} is not YAML: {_AS_TEXT}") from None
    if isinstance(value, list):
        if value and is_uniform(value):
            return value
        raise TypeError(f"parameter {name}: {text!r} is no list of values of one type: {_AS_TEXT}")
    if isinstance(value, (bool, int, float, str, bytes)):
        return value
    kind = "null" if value is None else type(value).__name__
    raise TypeError(f"parameter {name}: {text!r} is of YAML's type {kind}: {_AS_TEXT}")
