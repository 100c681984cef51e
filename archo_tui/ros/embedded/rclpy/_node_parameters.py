"""The part of `rclpy.node.Node` that keeps parameters, and the rules of their descriptors."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterEvent,
    SetParametersResult,
)
from rcl_interfaces.msg import Parameter as ParameterMsg
from rclpy.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import Parameter

if TYPE_CHECKING:
    from rclpy.clock import Clock
    from rclpy.publisher import Publisher

CallbackT = TypeVar("CallbackT")
Parameters = list[Parameter[Any]]
_NOT_SET = Parameter.Type.NOT_SET


class NodeParameters:
    """The part of Node that declares, checks, sets and lists parameters.

    Each change is published on /parameter_events, except by `undeclare_parameter`.
    """

    _clock: Clock
    _full_name: str
    _parameter_events: Publisher[ParameterEvent] | None = None

    def _init_parameters(
        self, overrides: dict[str, Any], allow_undeclared: bool, automatically_declare: bool
    ) -> None:
        self._parameters: dict[str, Parameter[Any]] = {}
        self._descriptors: dict[str, ParameterDescriptor] = {}
        self._parameter_overrides = overrides
        self._allow_undeclared_parameters = allow_undeclared
        self._declare_on_start = automatically_declare
        self._pre_set: list[Callable[[Parameters], Parameters]] = []
        self._on_set: list[Callable[[Parameters], SetParametersResult]] = []
        self._post_set: list[Callable[[Parameters], None]] = []

    def declare_parameter(
        self,
        name: str,
        value: Any = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Parameter[Any]:
        """Declare a parameter, set it, and return it."""
        if not isinstance(name, str):
            raise TypeError(f"a parameter's name is a str, not {type(name).__name__}")
        if not name:
            raise InvalidParameterException(name)
        if name in self._parameters:
            raise ParameterAlreadyDeclaredException([name])
        if value is None and descriptor is None:
            descriptor = ParameterDescriptor(dynamic_typing=True)
        descriptor = ParameterDescriptor() if descriptor is None else descriptor.__received__()
        descriptor.name = name
        if isinstance(value, Parameter.Type):
            descriptor.type, value = int(value), None
        elif not descriptor.dynamic_typing:
            descriptor.type = int(Parameter.Type.from_parameter_value(value))
        if not descriptor.dynamic_typing and descriptor.type == _NOT_SET:
            raise ValueError(f"Cannot declare parameter {name} as statically typed without a type")
        if not ignore_override:
            value = self._parameter_overrides.get(name, value)
        parameter: Parameter[Any] = Parameter(name, value=value)
        result = self._apply([parameter], {name: descriptor})
        if not result.successful:
            if result.reason.startswith("Wrong parameter type"):
                raise InvalidParameterTypeException(parameter, Parameter.Type(descriptor.type).name)
            raise InvalidParameterValueException(name, value, result.reason)
        return self._parameters[name]

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> Parameters:
        """Declare parameters of tuples (name, value, descriptor), and return them.

        The last two parts may be left out. If a name is already declared, none is declared.
        """
        prefix = f"{namespace}." if namespace else ""
        known = [prefix + name for name, *_ in parameters if prefix + name in self._parameters]
        if known:
            raise ParameterAlreadyDeclaredException(known)
        return [
            self.declare_parameter(prefix + name, value, descriptor, ignore_override)
            for name, value, descriptor in ((*given, None, None)[:3] for given in parameters)
        ]

    def undeclare_parameter(self, name: str) -> None:
        """Forget a parameter and its descriptor; no callback is called and no event published."""
        self._require(name)
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        del self._parameters[name], self._descriptors[name]

    def has_parameter(self, name: str) -> bool:
        """Return True if the parameter is declared, with or without a value."""
        return name in self._parameters

    def get_parameter(self, name: str) -> Parameter[Any]:
        """Return a parameter; without a value if it is undeclared and the node allows that."""
        if name not in self._parameters and self._allow_undeclared_parameters:
            return Parameter(name)
        self._require(name)
        parameter = self._parameters[name]
        if parameter.type_ == _NOT_SET and not self._descriptors[name].dynamic_typing:
            raise ParameterUninitializedException(name)
        return parameter

    def get_parameters(self, names: Sequence[str]) -> Parameters:
        """Return `get_parameter` of each name, with the same errors."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(
        self, name: str, alternative_value: Parameter[Any] | None = None
    ) -> Parameter[Any]:
        """Return a parameter, or the alternative if it is not declared or has no value."""
        found = self._parameters.get(name)
        if found is not None and found.type_ != _NOT_SET:
            return found
        return Parameter(name) if alternative_value is None else alternative_value

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter[Any]]:
        """Return the declared parameters below a prefix, by their names without the prefix."""
        start = f"{prefix}." if prefix else ""
        found = self._parameters.items()
        return {name[len(start) :]: p for name, p in found if name.startswith(start)}

    def set_parameters(self, parameter_list: Parameters) -> list[SetParametersResult]:
        """Set parameters one after the other, and return for each if it was set, or why not.

        A parameter without a value undeclares one that is dynamically typed.
        """
        _check_are_parameters(parameter_list)
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: Parameters) -> SetParametersResult:
        """Set all parameters or none, and return if they were set, or why not.

        Pre-set and on-set callbacks are called before, post-set ones after the change. Where the
        node allows undeclared parameters, setting one declares it, with dynamic typing.
        """
        _check_are_parameters(parameter_list)
        if self._pre_set:  # Each callback gets the request; all that they return is set.
            parameter_list = [one for callback in self._pre_set for one in callback(parameter_list)]
            if not parameter_list:
                reason = "parameter list cannot be empty: a pre-set callback returned none"
                return SetParametersResult(successful=False, reason=reason)
        unknown = [p.name for p in parameter_list if p.name not in self._parameters]
        if unknown and not self._allow_undeclared_parameters:
            raise ParameterNotDeclaredException(unknown)
        return self._apply(parameter_list, None)

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return a copy of a parameter's descriptor."""
        if name not in self._parameters and self._allow_undeclared_parameters:
            return ParameterDescriptor()
        self._require(name)
        descriptor: ParameterDescriptor = self._descriptors[name].__received__()
        return descriptor

    def describe_parameters(self, names: Sequence[str]) -> list[ParameterDescriptor]:
        """Return `describe_parameter` of each name."""
        return [self.describe_parameter(name) for name in names]

    def get_parameter_type(self, name: str) -> int:
        """Return a declared parameter's type, one of ParameterType's constants."""
        self._require(name)
        return self._parameters[name].type_.value

    def get_parameter_types(self, names: Sequence[str]) -> list[int]:
        """Return `get_parameter_type` of each name."""
        return [self.get_parameter_type(name) for name in names]

    def list_parameters(self, prefixes: list[str], depth: int) -> ListParametersResult:
        """Return the names of declared parameters, and their prefixes."""
        starts = [f"{prefix}." for prefix in prefixes] or [""]
        names = [
            name
            for name in self._parameters
            if name in prefixes
            or any(
                name.startswith(s) and (not depth or name[len(s) :].count(".") < depth)
                for s in starts
            )
        ]
        found = dict.fromkeys(name.rpartition(".")[0] for name in names if "." in name)
        return ListParametersResult(names=names, prefixes=list(found))

    def add_pre_set_parameters_callback(self, callback: Callable[[Parameters], Parameters]) -> None:
        """Add a callback that replaces the list of parameters that are to be set."""
        self._pre_set.insert(0, callback)

    def add_on_set_parameters_callback(
        self, callback: Callable[[Parameters], SetParametersResult]
    ) -> None:
        """Add a callback that may refuse parameters, also when they are declared."""
        self._on_set.insert(0, _checked_callback(callback))

    def add_post_set_parameters_callback(self, callback: Callable[[Parameters], None]) -> None:
        """Add a callback that gets the list of parameters after they are set or declared."""
        self._post_set.insert(0, _checked_callback(callback))

    def remove_pre_set_parameters_callback(self, callback: Any) -> None:
        """Remove a callback of `add_pre_set_...`; raise ValueError if it is not there."""
        self._pre_set.remove(callback)

    def remove_on_set_parameters_callback(self, callback: Any) -> None:
        """Remove a callback of `add_on_set_...`; raise ValueError if it is not there."""
        self._on_set.remove(callback)

    def remove_post_set_parameters_callback(self, callback: Any) -> None:
        """Remove a callback of `add_post_set_...`; raise ValueError if it is not there."""
        self._post_set.remove(callback)

    def _require(self, name: str) -> None:
        if name not in self._parameters:
            raise ParameterNotDeclaredException(name)

    def _apply(
        self, parameters: Parameters, new: dict[str, ParameterDescriptor] | None
    ) -> SetParametersResult:
        """Check parameters, ask the on-set callbacks, set and publish all, call the post-set ones.

        At the first refusal its result is returned, and no parameter is set.
        """
        for parameter in parameters:
            descriptor = (self._descriptors if new is None else new).get(parameter.name)
            if descriptor is not None:
                reason = _refusal(parameter, descriptor, declaring=new is not None)
                if reason:
                    return SetParametersResult(successful=False, reason=reason)
        for callback in self._on_set:
            result = callback(parameters)
            if not isinstance(result, SetParametersResult):
                reason = "Callback returned an invalid type"
                warnings.warn(f"{reason}, it should return SetParametersResult.", stacklevel=2)
                return SetParametersResult(successful=False, reason=reason)
            if not result.successful:
                return result
        self._store(parameters, new)
        for told in self._post_set:
            told(parameters)
        return SetParametersResult(successful=True)

    def _store(self, parameters: Parameters, new: dict[str, ParameterDescriptor] | None) -> None:
        event: dict[str, list[ParameterMsg]] = {"new": [], "changed": [], "deleted": []}
        for parameter in parameters:
            name, message = parameter.name, parameter.to_parameter_msg()
            if new is None and parameter.type_ == _NOT_SET:
                self._parameters.pop(name, None)
                self._descriptors.pop(name, None)
                event["deleted"].append(message)
                continue
            was_set = self.get_parameter_or(name).type_ != _NOT_SET
            event["changed" if was_set else "new"].append(message)
            if new is not None:
                self._descriptors[name] = new[name]
            descriptor = self._descriptors.setdefault(
                name, ParameterDescriptor(name=name, dynamic_typing=True)
            )
            if descriptor.dynamic_typing:
                descriptor.type = int(parameter.type_)
            self._parameters[name] = parameter
        if self._parameter_events is not None:
            self._parameter_events.publish(
                ParameterEvent(
                    stamp=self._clock.now().to_msg(),
                    node=self._full_name,
                    **{f"{kind}_parameters": messages for kind, messages in event.items()},
                )
            )


def _checked_callback(callback: CallbackT) -> CallbackT:
    if not callable(callback):  # As for `add_...(self.check())`, where `self.check` is meant.
        raise TypeError(f"Callback must be callable, got {type(callback)}")
    return callback


def _check_are_parameters(parameters: Sequence[Any]) -> None:
    for parameter in parameters:
        if not isinstance(parameter, Parameter):
            raise TypeError(f"parameter must be instance of type '{Parameter!r}'")


def _refusal(parameter: Parameter[Any], descriptor: ParameterDescriptor, *, declaring: bool) -> str:
    """Return why a descriptor forbids a parameter's value, in rclpy's words, or ""."""
    kind = parameter.type_
    if descriptor.read_only and not declaring:
        return f"Trying to set a read-only parameter: {parameter.name}."
    if not descriptor.dynamic_typing:
        if kind == _NOT_SET:
            return "" if declaring else "Static parameter cannot be undeclared"
        if kind != descriptor.type:
            wanted = Parameter.Type(descriptor.type)
            return f"Wrong parameter type, expected '{wanted}' got '{kind}'"
    if kind == Parameter.Type.INTEGER and descriptor.integer_range:
        return _out_of_range(parameter, descriptor.integer_range[0], 0.0)
    if kind == Parameter.Type.DOUBLE and descriptor.floating_point_range:
        return _out_of_range(parameter, descriptor.floating_point_range[0], 1e-6)
    return ""


def _out_of_range(parameter: Parameter[Any], allowed: Any, tolerance: float) -> str:
    low, high = sorted((allowed.from_value, allowed.to_value))
    name, value, step = parameter.name, parameter.value, allowed.step

    def close(one: float) -> bool:
        return math.isclose(one, value, rel_tol=tolerance)

    if close(low) or close(high):
        return ""
    if not low < value < high:
        return f"Parameter {name} out of range. Min: {low}, Max: {high}, value: {value}"
    if step and not close(low + round((value - low) / step) * step):
        said = f"The parameter value for {name} is not close enough to a valid step."
        return f"{said} Min: {low}, max: {high}, value: {value}, step: {step}"
    return ""
