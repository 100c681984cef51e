"""The exceptions of `rclpy.exceptions`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rclpy._rclpy_pybind11 import InvalidHandle as InvalidHandle
from rclpy._rclpy_pybind11 import TimerCancelledError as TimerCancelledError

if TYPE_CHECKING:
    from rclpy.parameter import Parameter


class NotInitializedException(Exception):
    """A use of rclpy before `rclpy.init()`."""

    def __init__(self, message: str | None = None) -> None:
        said = "rclpy.init() has not been called."
        super().__init__(said if message is None else f"{said} msg:{message}")


class NameValidationException(Exception):
    """A name that ROS does not allow."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        pointer = f"{' ' * invalid_index}^"
        super().__init__(f"Invalid {name_type}: {error_msg}:\n  '{name}'\n   {pointer}")


class InvalidNamespaceException(NameValidationException):
    """A namespace that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("namespace", name, error_msg, invalid_index)


class InvalidNodeNameException(NameValidationException):
    """A node name that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("node name", name, error_msg, invalid_index)


class InvalidTopicNameException(NameValidationException):
    """A topic name that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("topic name", name, error_msg, invalid_index)


class InvalidServiceNameException(NameValidationException):
    """A service name that ROS does not allow."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__("service name", name, error_msg, invalid_index)


class ParameterException(Exception):
    """The base of errors with parameters."""

    def __init__(self, error_msg: str, parameters: Any, *args: Any) -> None:
        super().__init__(f"{error_msg}: {parameters}", *args)


class ParameterNotDeclaredException(ParameterException):
    """A use of a parameter before it is declared."""

    def __init__(self, parameters: Any, *args: Any) -> None:
        super().__init__("Invalid access to undeclared parameter(s)", parameters, *args)


class ParameterAlreadyDeclaredException(ParameterException):
    """A second declaration of a parameter."""

    def __init__(self, parameters: Any, *args: Any) -> None:
        super().__init__("Parameter(s) already declared", parameters, *args)


class InvalidParameterException(ParameterException):
    """A parameter name that is not allowed."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__("Invalid parameter name", parameter, *args)


class InvalidParameterTypeException(ParameterException):
    """A parameter value that is not of the declared type."""

    def __init__(self, parameter: Parameter[Any], type_name: str, *args: Any) -> None:
        Exception.__init__(
            self,
            f"Trying to set parameter '{parameter.name}' to '{parameter.value}' of type "
            f"'{parameter.type_.name}', expecting type '{type_name}': {parameter.name}",
            *args,
        )


class InvalidParameterValueException(ParameterException):
    """A parameter value that its range or a callback refused."""

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        Exception.__init__(
            self,
            f"Invalid parameter value ({value}) for parameter. Reason: {reason}: {parameter}",
        )


class ParameterImmutableException(ParameterException):
    """A change of a read-only parameter."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__("Attempted to modify read-only parameter", parameter, *args)


class ParameterUninitializedException(ParameterException):
    """A reading of a statically typed parameter without a value."""

    def __init__(self, parameter: Any, *args: Any) -> None:
        super().__init__(f"The parameter '{parameter}' is not initialized", parameter, *args)


class ROSInterruptException(Exception):
    """A shutdown of the context during a sleep."""

    def __init__(self) -> None:
        super().__init__("rclpy.shutdown() has been called")


class NoTypeSupportImportedException(Exception):
    """An interface without type support; here every interface file has it."""

    def __init__(self) -> None:
        super().__init__("no type_support imported")
