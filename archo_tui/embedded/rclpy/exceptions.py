"""The exceptions of `rclpy.exceptions`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy._rclpy_pybind11 import InvalidHandle as InvalidHandle
from rclpy._rclpy_pybind11 import TimerCancelledError as TimerCancelledError

if TYPE_CHECKING:
    from rclpy.parameter import Parameter


class NotInitializedException(Exception):
    """The error for a use of rclpy before `rclpy.init()`, or after `shutdown()`."""

    def __init__(self, message: str | None = None) -> None:
        said = "rclpy.init() has not been called."
        super().__init__(said if message is None else f"{said} msg:{message}")


class NameValidationException(Exception):
    """The base of errors for a name that ROS does not allow; the text points at the character."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        pointer = f"{' ' * invalid_index}^"
        super().__init__(f"Invalid {name_type}: {error_msg}:\n  '{name}'\n   {pointer}")


class InvalidNamespaceException(NameValidationException):
    """The error for a namespace that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("namespace", name, error_msg, invalid_index)


class InvalidNodeNameException(NameValidationException):
    """The error for a node name that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("node name", name, error_msg, invalid_index)


class InvalidTopicNameException(NameValidationException):
    """The error for a topic name that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("topic name", name, error_msg, invalid_index)


class InvalidServiceNameException(NameValidationException):
    """The error for a service name that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("service name", name, error_msg, invalid_index)


class ParameterException(Exception):
    """The base of errors with parameters."""

    def __init__(self, error_msg: str, parameters: Any, *args: Any) -> None:
        super().__init__(f"{error_msg}: {parameters}", *args)


class ParameterNotDeclaredException(ParameterException):
    """The error for a use of parameters that are not declared."""

    def __init__(self, parameters: Any, *args: Any) -> None:
        super().__init__("Invalid access to undeclared parameter(s)", parameters, *args)


class ParameterAlreadyDeclaredException(ParameterException):
    """The error for a second declaration of parameters."""

    def __init__(self, parameters: Any, *args: Any) -> None:
        super().__init__("Parameter(s) already declared", parameters, *args)


class InvalidParameterException(ParameterException):
    """The error for a parameter name that is not allowed: an empty one."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__("Invalid parameter name", parameter, *args)


class InvalidParameterTypeException(ParameterException):
    """The error for a declaration whose value is of another type than the declared one."""

    def __init__(self, parameter: Parameter[Any], type_name: str, *args: Any) -> None:
        Exception.__init__(
            self,
            f"Trying to set parameter '{parameter.name}' to '{parameter.value}' of type "
            f"'{parameter.type_.name}', expecting type '{type_name}': {parameter.name}",
            *args,
        )


class InvalidParameterValueException(ParameterException):
    """The error for a value that a parameter's descriptor or a callback refuses.

    `declare_parameter` and `set_descriptor` raise it; `set_parameters` returns the reason instead.
    """

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        Exception.__init__(
            self,
            f"Invalid parameter value ({value}) for parameter. Reason: {reason}: {parameter}",
        )


class ParameterImmutableException(ParameterException):
    """The error for undeclaring a read-only parameter, or giving it another descriptor."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__("Attempted to modify read-only parameter", parameter, *args)


class ParameterUninitializedException(ParameterException):
    """The error for reading a statically typed parameter that has no value."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__(f"The parameter '{parameter}' is not initialized", parameter, *args)


class ROSInterruptException(Exception):
    """The error of `Rate.sleep()` when the context is shut down."""

    def __init__(self) -> None:
        super().__init__("rclpy.shutdown() has been called")


class NoTypeSupportImportedException(Exception):
    """The error for a class of the user's own without type support.

    Classes made from interface files never raise it.
    """

    def __init__(self) -> None:
        super().__init__("no type_support imported")
