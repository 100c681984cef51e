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
    """The base of errors for a name that ROS does not allow."""

    _kind = "name"

    def __init__(self, name: str, error_msg: str) -> None:
        super().__init__(f"Invalid {self._kind}: {error_msg}: '{name}'")


class InvalidNamespaceException(NameValidationException):
    """The error for a namespace that ROS does not allow."""

    _kind = "namespace"


class InvalidNodeNameException(NameValidationException):
    """The error for a node name that ROS does not allow."""

    _kind = "node name"


class InvalidTopicNameException(NameValidationException):
    """The error for a topic name that ROS does not allow."""

    _kind = "topic name"


class InvalidServiceNameException(NameValidationException):
    """The error for a service name that ROS does not allow."""

    _kind = "service name"


class ParameterException(Exception):
    """The base of errors with parameters."""

    _said = "Parameter error"

    def __init__(self, parameters: Any) -> None:
        super().__init__(f"{self._said}: {parameters}")


class ParameterNotDeclaredException(ParameterException):
    """The error for a use of parameters that are not declared."""

    _said = "Invalid access to undeclared parameter(s)"


class ParameterAlreadyDeclaredException(ParameterException):
    """The error for a second declaration of parameters."""

    _said = "Parameter(s) already declared"


class InvalidParameterException(ParameterException):
    """The error for a parameter name that is not allowed: an empty one."""

    _said = "Invalid parameter name"


class InvalidParameterTypeException(ParameterException):
    """The error for a declaration whose value is of another type than the declared one."""

    def __init__(self, parameter: Parameter[Any], type_name: str) -> None:
        Exception.__init__(
            self,
            f"Trying to set parameter '{parameter.name}' to '{parameter.value}' of type "
            f"'{parameter.type_.name}', expecting type '{type_name}': {parameter.name}",
        )


class InvalidParameterValueException(ParameterException):
    """The error for a value that a parameter's descriptor or a callback refuses.

    `declare_parameter` raises it; `set_parameters` returns the reason instead.
    """

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        Exception.__init__(
            self,
            f"Invalid parameter value ({value}) for parameter. Reason: {reason}: {parameter}",
        )


class ParameterImmutableException(ParameterException):
    """The error for undeclaring a read-only parameter."""

    _said = "Attempted to modify read-only parameter"


class ParameterUninitializedException(ParameterException):
    """The error for reading a statically typed parameter that has no value."""

    _said = "The parameter is not initialized"


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
