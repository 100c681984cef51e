"""The part of `rclpy.node.Node` that keeps parameters."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterEvent,
    ParameterValue,
    SetParametersResult,
)
from rcl_interfaces.msg import Parameter as ParameterMsg
from rclpy._parameter_rules import check
from rclpy.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.parameter import PARAMETER_SEPARATOR_STRING, Parameter

if TYPE_CHECKING:
    from rclpy.clock import Clock
    from rclpy.publisher import Publisher

PreSet = Callable[[list[Parameter[Any]]], list[Parameter[Any]]]
OnSet = Callable[[list[Parameter[Any]]], SetParametersResult]
PostSet = Callable[[list[Parameter[Any]]], None]


_EMPTY = (
    "parameter list cannot be empty, this might be due to pre_set_parameters_callback modifying "
    "the original parameters list."
)


class NodeParameters:
    """The part of Node that declares, checks, sets and lists parameters.

    Each change is published on /parameter_events, except by `undeclare_parameter`.
    """

    _clock: Clock
    _parameter_events: Publisher[ParameterEvent] | None

    def _init_parameters(
        self, overrides: dict[str, Any], allow_undeclared: bool, automatically_declare: bool
    ) -> None:
        self._parameters: dict[str, Parameter[Any]] = {}
        self._descriptors: dict[str, ParameterDescriptor] = {}
        self._parameter_overrides = overrides
        self._allow_undeclared_parameters = allow_undeclared
        self._pre_set_parameters_callbacks: list[PreSet] = []
        self._on_set_parameters_callbacks: list[OnSet] = []
        self._post_set_parameters_callbacks: list[PostSet] = []
        self._declare_on_start = automatically_declare

    def get_fully_qualified_name(self) -> str:
        raise NotImplementedError

    def declare_parameter(
        self,
        name: str,
        value: Any = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Parameter[Any]:
        """Declare a parameter, set it, and return it."""
        return self.declare_parameters("", [(name, value, descriptor)], ignore_override)[0]

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> list[Parameter[Any]]:
        """Declare several parameters, and return them.

        If a name is empty or already declared, none is declared; if a value or type is refused,
        those before it stay declared. In rclpy a wrong type, too, declares none.
        """
        prefix = f"{namespace}{PARAMETER_SEPARATOR_STRING}" if namespace else ""
        whole = [_checked(place, prefix, given) for place, given in enumerate(parameters)]
        known = [name for name, _, _ in whole if name in self._parameters]
        if known:
            raise ParameterAlreadyDeclaredException(known)
        declared = []
        for one in whole:
            declared.append(self._declare(*one, ignore_override=ignore_override))
        return declared

    def _declare(
        self,
        name: str,
        value: Any,
        descriptor: ParameterDescriptor | None,
        *,
        ignore_override: bool,
    ) -> Parameter[Any]:
        name_only = value is None and descriptor is None
        descriptor = ParameterDescriptor() if descriptor is None else descriptor.__received__()
        if name_only:
            warnings.warn(
                f"when declaring parameter named '{name}', declaring a parameter only providing "
                "its name is deprecated: give a value, a type, or a descriptor with "
                "dynamic_typing=True",
                stacklevel=4,
            )
            descriptor.dynamic_typing = True
        descriptor.name = name
        if isinstance(value, Parameter.Type):
            if value == Parameter.Type.NOT_SET:
                raise ValueError(
                    f"Cannot declare parameter {name} as statically typed of type NOT_SET"
                )
            if descriptor.dynamic_typing:
                raise ValueError(
                    f"When declaring parameter {name} passing a descriptor with "
                    "`dynamic_typing=True` is not allowed when the parameter type is provided"
                )
            descriptor.type, value = int(value), None
        elif isinstance(value, ParameterValue):
            # Only the type counts: rclpy does not convert it to a value.
            if not descriptor.dynamic_typing:
                descriptor.type = value.type
        elif not descriptor.dynamic_typing:
            descriptor.type = int(Parameter.Type.from_parameter_value(value))
        if not descriptor.dynamic_typing and descriptor.type == Parameter.Type.NOT_SET:
            raise ValueError(
                "Cannot declare a statically typed parameter with default value of type "
                "PARAMETER_NOT_SET"
            )
        if not ignore_override:
            value = self._parameter_overrides.get(name, value)
        if isinstance(value, ParameterValue):
            raise ValueError(
                "Cannot declare a Parameter from a ParameterValue without it being included in "
                "self._parameter_overrides, and ignore_override=False"
            )
        parameter: Parameter[Any] = Parameter(name, value=value)
        result = self._apply([parameter], {name: descriptor})
        if not result.successful:
            if result.reason.startswith("Wrong parameter type"):
                raise InvalidParameterTypeException(parameter, Parameter.Type(descriptor.type).name)
            raise InvalidParameterValueException(name, value, result.reason)
        return self._parameters[name]

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
        """Return a parameter.

        An undeclared one is returned without a value if the node allows undeclared parameters.
        """
        if name not in self._parameters and self._allow_undeclared_parameters:
            return Parameter(name)
        self._require(name)
        parameter = self._parameters[name]
        if parameter.type_ == Parameter.Type.NOT_SET and not self._descriptors[name].dynamic_typing:
            raise ParameterUninitializedException(name)
        return parameter

    def get_parameters(self, names: Sequence[str]) -> list[Parameter[Any]]:
        """Return `get_parameter` of each name, with the same errors."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(
        self, name: str, alternative_value: Parameter[Any] | None = None
    ) -> Parameter[Any]:
        """Return a parameter, or the alternative if it is not declared or has no value.

        The alternative None means a parameter of that name without a value.
        """
        found = self._parameters.get(name)
        if found is not None and found.type_ != Parameter.Type.NOT_SET:
            return found
        return Parameter(name) if alternative_value is None else alternative_value

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter[Any]]:
        """Return the declared parameters below a prefix, by their names without the prefix.

        The prefix "" means all parameters.
        """
        start = f"{prefix}{PARAMETER_SEPARATOR_STRING}" if prefix else ""
        found = self._parameters.items()
        return {name[len(start) :]: p for name, p in found if name.startswith(start)}

    def set_parameters(self, parameter_list: list[Parameter[Any]]) -> list[SetParametersResult]:
        """Set parameters one after the other, and return for each if it was set, or why not.

        A parameter without a value undeclares one that is dynamically typed. For callbacks and
        undeclared parameters see `set_parameters_atomically`.
        """
        _check_are_parameters(parameter_list)
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(
        self, parameter_list: list[Parameter[Any]]
    ) -> SetParametersResult:
        """Set all parameters or none, and return if they were set, or why not."""
        _check_are_parameters(parameter_list)
        before = self._pre_set_parameters_callbacks
        if before:  # Each callback gets the request; all that they return is set.
            parameter_list = [one for callback in before for one in callback(parameter_list)]
            if not parameter_list:
                return SetParametersResult(successful=False, reason=_EMPTY)
        unknown = [p.name for p in parameter_list if p.name not in self._parameters]
        if unknown and not self._allow_undeclared_parameters:
            raise ParameterNotDeclaredException(unknown)
        return self._apply(parameter_list, None)

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return a copy of a parameter's descriptor; rclpy returns the descriptor itself.

        For an undeclared parameter, where the node allows these, the descriptor is empty.
        """
        if name not in self._parameters and self._allow_undeclared_parameters:
            return ParameterDescriptor()
        self._require(name)
        descriptor: ParameterDescriptor = self._descriptors[name].__received__()
        return descriptor

    def set_descriptor(
        self,
        name: str,
        descriptor: ParameterDescriptor,
        alternative_value: ParameterValue | None = None,
    ) -> ParameterValue:
        """Replace a parameter's descriptor by a copy, and return the parameter's value."""
        if name not in self._parameters:
            if not self._allow_undeclared_parameters:
                raise ParameterNotDeclaredException(name)
            return Parameter(name).get_parameter_value()
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(name)
        new = descriptor.__received__()
        new.name = name
        candidates = [self._parameters[name]]
        if alternative_value is not None:
            message = ParameterMsg(name=name, value=alternative_value)
            candidates.append(Parameter.from_parameter_msg(message))
        for parameter in candidates:
            result = self._apply([parameter], {name: new})
            if result.successful:
                return self._parameters[name].get_parameter_value()
        raise InvalidParameterValueException(name, candidates[-1].value, result.reason)

    def describe_parameters(self, names: Sequence[str]) -> list[ParameterDescriptor]:
        """Return `describe_parameter` of each name, with the same errors."""
        return [self.describe_parameter(name) for name in names]

    def get_parameter_type(self, name: str) -> int:
        """Return a declared parameter's type, one of ParameterType's constants."""
        self._require(name)
        return self._parameters[name].type_.value

    def get_parameter_types(self, names: Sequence[str]) -> list[int]:
        """Return `get_parameter_type` of each name, with the same errors."""
        return [self.get_parameter_type(name) for name in names]

    def list_parameters(self, prefixes: list[str], depth: int) -> ListParametersResult:
        """Return the names of declared parameters, and their prefixes.

        A name's prefix is the part before its last dot; each prefix is returned once.
        """
        if not isinstance(prefixes, list):
            raise TypeError("The prefixes argument must be a list")
        if not all(isinstance(prefix, str) for prefix in prefixes):
            raise TypeError("All prefixes must be instances of type str")
        if not isinstance(depth, int):
            raise TypeError("The depth must be instance of type int")
        if depth < 0:
            raise ValueError("The depth must be greater than or equal to zero")
        result = ListParametersResult()
        names, found = [], []
        dot = PARAMETER_SEPARATOR_STRING

        def is_near(rest: str) -> bool:
            return not depth or rest.count(dot) < depth

        for name in self._parameters:
            if prefixes:
                listed = any(
                    name == p or (name.startswith(p + dot) and is_near(name[len(p) + 1 :]))
                    for p in prefixes
                )
            else:
                listed = is_near(name)
            if not listed:
                continue
            names.append(name)
            prefix = name.rpartition(dot)[0]
            if prefix and prefix not in found:
                found.append(prefix)
        result.names, result.prefixes = names, found
        return result

    def add_pre_set_parameters_callback(self, callback: PreSet) -> None:
        """Add a callback that replaces the list of parameters that are to be set."""
        self._pre_set_parameters_callbacks.insert(0, callback)

    def add_on_set_parameters_callback(self, callback: OnSet) -> None:
        """Add a callback that may refuse parameters, also when they are declared."""
        _check_is_callable(callback)
        self._on_set_parameters_callbacks.insert(0, callback)

    def add_post_set_parameters_callback(self, callback: PostSet) -> None:
        """Add a callback that gets the list of parameters after they are set or declared.

        The callback added last is called first.
        """
        _check_is_callable(callback)
        self._post_set_parameters_callbacks.insert(0, callback)

    def remove_pre_set_parameters_callback(self, callback: PreSet) -> None:
        """Remove a callback of `add_pre_set_...`; raise ValueError if it is not there."""
        self._pre_set_parameters_callbacks.remove(callback)

    def remove_on_set_parameters_callback(self, callback: OnSet) -> None:
        """Remove a callback of `add_on_set_...`; raise ValueError if it is not there."""
        self._on_set_parameters_callbacks.remove(callback)

    def remove_post_set_parameters_callback(self, callback: PostSet) -> None:
        """Remove a callback of `add_post_set_...`; raise ValueError if it is not there."""
        self._post_set_parameters_callbacks.remove(callback)

    def _require(self, name: str) -> None:
        if name not in self._parameters:
            raise ParameterNotDeclaredException(name)

    def _apply(
        self,
        parameters: list[Parameter[Any]],
        new: dict[str, ParameterDescriptor] | None,
    ) -> SetParametersResult:
        """Check parameters, ask the on-set callbacks, set and publish all, call the post-set ones.

        At the first refusal its result is returned, and no parameter is set.
        """
        for parameter in parameters:
            descriptor = (self._descriptors if new is None else new).get(parameter.name)
            if descriptor is not None:
                reason = check(parameter, descriptor, declaring=new is not None)
                if reason:
                    return SetParametersResult(successful=False, reason=reason)
        for callback in self._on_set_parameters_callbacks:
            result = callback(parameters)
            if not isinstance(result, SetParametersResult):
                warnings.warn(
                    "Callback returned an invalid type, it should return SetParameterResult.",
                    stacklevel=2,
                )
                return SetParametersResult(
                    successful=False, reason="Callback returned an invalid type"
                )
            if not result.successful:
                return result
        self._store(parameters, new)
        for told in self._post_set_parameters_callbacks:
            told(parameters)
        return SetParametersResult(successful=True)

    def _store(
        self, parameters: list[Parameter[Any]], new: dict[str, ParameterDescriptor] | None
    ) -> None:
        event: dict[str, list[ParameterMsg]] = {"new": [], "changed": [], "deleted": []}
        for parameter in parameters:
            name = parameter.name
            if new is None and parameter.type_ == Parameter.Type.NOT_SET:
                self._parameters.pop(name, None)
                self._descriptors.pop(name, None)
                event["deleted"].append(parameter.to_parameter_msg())
                continue
            was_set = self.get_parameter_or(name).type_ != Parameter.Type.NOT_SET
            event["changed" if was_set else "new"].append(parameter.to_parameter_msg())
            if new is not None:
                self._descriptors[name] = new[name]
            elif name not in self._descriptors:
                self._descriptors[name] = ParameterDescriptor(name=name, dynamic_typing=True)
            if self._descriptors[name].dynamic_typing:
                self._descriptors[name].type = int(parameter.type_)
            self._parameters[name] = parameter
        if self._parameter_events is not None:
            self._parameter_events.publish(
                ParameterEvent(
                    stamp=self._clock.now().to_msg(),
                    node=self.get_fully_qualified_name(),
                    **{f"{kind}_parameters": messages for kind, messages in event.items()},
                )
            )


def _checked(
    place: int, prefix: str, given: tuple[Any, ...]
) -> tuple[str, Any, ParameterDescriptor | None]:
    """Return the full name, value and descriptor of one tuple given to `declare_parameters`."""
    where = f"at index {place} in parameters list"
    if not 1 <= len(given) <= 3:
        raise TypeError(
            f"Invalid parameter tuple length {where}: {given}; expecting 1 to 3 elements"
        )
    name, value, descriptor = (*given, None, None)[:3]
    if not isinstance(name, str):
        raise TypeError(f"First element {name} {where} is not a str.")
    if not name:
        raise InvalidParameterException(name)
    if descriptor is not None and not isinstance(descriptor, ParameterDescriptor):
        raise TypeError(
            f"Third element {descriptor} {where} is not a rcl_interfaces.msg.ParameterDescriptor."
        )
    return prefix + name, value, descriptor


def _check_is_callable(callback: Any) -> None:
    if not callable(callback):
        raise TypeError(f"Callback must be callable, got {type(callback)}")


def _check_are_parameters(parameters: Sequence[Any]) -> None:
    for parameter in parameters:
        if not isinstance(parameter, Parameter):
            raise TypeError(f"parameter must be instance of type '{Parameter!r}'")
