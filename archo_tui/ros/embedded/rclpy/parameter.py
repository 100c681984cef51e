"""The module `rclpy.parameter`: a parameter and its type."""

from __future__ import annotations

import array
from enum import IntEnum
from typing import Any, Generic, TypeVar

import yaml
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterType, ParameterValue

PARAMETER_SEPARATOR_STRING = "."

AllowableParameterValueT = TypeVar("AllowableParameterValueT")

_SEQUENCES = (list, tuple, array.array)


class Parameter(Generic[AllowableParameterValueT]):
    """A parameter: a name and a typed value, which do not change."""

    class Type(IntEnum):
        """The types a parameter may have."""

        NOT_SET = ParameterType.PARAMETER_NOT_SET
        BOOL = ParameterType.PARAMETER_BOOL
        INTEGER = ParameterType.PARAMETER_INTEGER
        DOUBLE = ParameterType.PARAMETER_DOUBLE
        STRING = ParameterType.PARAMETER_STRING
        BYTE_ARRAY = ParameterType.PARAMETER_BYTE_ARRAY
        BOOL_ARRAY = ParameterType.PARAMETER_BOOL_ARRAY
        INTEGER_ARRAY = ParameterType.PARAMETER_INTEGER_ARRAY
        DOUBLE_ARRAY = ParameterType.PARAMETER_DOUBLE_ARRAY
        STRING_ARRAY = ParameterType.PARAMETER_STRING_ARRAY

        @classmethod
        def from_parameter_value(cls, value: Any) -> Parameter.Type:
            """Return the type of a Python value; raise TypeError if no parameter can have it.

            None is NOT_SET, and an empty list a BYTE_ARRAY.
            """
            if value is None:
                return cls.NOT_SET
            for kind, element in _SCALARS.items():
                if isinstance(value, element):
                    return kind
            if isinstance(value, _SEQUENCES):
                for kind, element in _ELEMENTS.items():
                    if all(isinstance(item, element) for item in value):
                        return kind
                raise TypeError(
                    f"The given value is not a list of one of the allowed types '{value}'."
                )
            raise TypeError(f"The given value is not one of the allowed types '{value}'.")

        def check(self, value: Any) -> bool:
            """Return True if a parameter of this type may have that value.

            NOT_SET may have None, and no other type may. True and False are integers, too.
            """
            if self == Parameter.Type.NOT_SET:
                return value is None
            if self in _SCALARS:
                return isinstance(value, _SCALARS[self])
            element = _ELEMENTS[self]
            numbers = self in (Parameter.Type.INTEGER_ARRAY, Parameter.Type.DOUBLE_ARRAY)
            return isinstance(value, _SEQUENCES if numbers else (list, tuple)) and all(
                isinstance(item, element) and not (isinstance(item, bytes) and len(item) != 1)
                for item in value
            )

    def __init__(self, name: str, type_: Type | None = None, value: Any = None) -> None:
        if type_ is None:
            type_ = Parameter.Type.from_parameter_value(value)
        if not isinstance(type_, Parameter.Type):
            raise TypeError(f"type must be an instance of '{Parameter.Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value}' do not agree")
        self._name = name
        self._type = type_
        self._value = value

    @property
    def name(self) -> str:
        """Return the name, in which dots separate the levels."""
        return self._name

    @property
    def type_(self) -> Type:
        """Return the type of the value."""
        return self._type

    @property
    def value(self) -> Any:
        """Return the value: bool, int, float, str, or a sequence of these or of bytes.

        The value of a parameter that is not set is None.
        """
        return self._value

    def get_parameter_value(self) -> ParameterValue:
        """Return the value as rcl_interfaces/ParameterValue."""
        message = ParameterValue(type=int(self._type))
        if self._type != Parameter.Type.NOT_SET:
            setattr(message, _field(self._type), self._value)
        return message

    def to_parameter_msg(self) -> ParameterMsg:
        """Return the parameter as rcl_interfaces/Parameter."""
        return ParameterMsg(name=self._name, value=self.get_parameter_value())

    @classmethod
    def from_parameter_msg(cls, message: ParameterMsg) -> Parameter[Any]:
        """Return the parameter in a message of rcl_interfaces/Parameter."""
        kind = Parameter.Type(message.value.type)
        unset = kind == Parameter.Type.NOT_SET
        return cls(message.name, kind, None if unset else getattr(message.value, _field(kind)))


def get_parameter_value(string_value: str) -> ParameterValue:
    """Return the value that a text means on a command line: read as YAML, else a string.

    A null, a list of mixed types and a text that is not YAML are taken as strings.
    """
    try:
        value = yaml.safe_load(string_value)
    except yaml.parser.ParserError:
        value = string_value
    kind = Parameter.Type.BOOL_ARRAY
    if value != []:
        try:
            kind = Parameter.Type.from_parameter_value(value)
        except TypeError:
            value = string_value if isinstance(value, list) else value
            kind = Parameter.Type.STRING
    if kind in (Parameter.Type.NOT_SET, Parameter.Type.STRING):
        text = string_value if value is None else value
        return ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
    return Parameter("value", kind, value).get_parameter_value()


def parameter_value_to_python(parameter_value: ParameterValue) -> Any:
    """Return the Python value of rcl_interfaces/ParameterValue; None for one that is not set."""
    kind = parameter_value.type
    if kind not in Parameter.Type.__members__.values():
        raise RuntimeError(f"unexpected parameter type {kind}")
    if kind == Parameter.Type.NOT_SET:
        return None
    value = getattr(parameter_value, _field(Parameter.Type(kind)))
    return list(value) if isinstance(value, array.array) else value


def _field(kind: Parameter.Type) -> str:
    return f"{kind.name.lower()}_value"


# bool comes before int, because a Python bool is an int.
_SCALARS = {
    Parameter.Type.BOOL: bool,
    Parameter.Type.INTEGER: int,
    Parameter.Type.DOUBLE: float,
    Parameter.Type.STRING: str,
}
_ELEMENTS = {
    Parameter.Type.BYTE_ARRAY: bytes,
    Parameter.Type.BOOL_ARRAY: bool,
    Parameter.Type.INTEGER_ARRAY: int,
    Parameter.Type.DOUBLE_ARRAY: float,
    Parameter.Type.STRING_ARRAY: str,
}
