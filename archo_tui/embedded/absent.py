"""The parts of rclpy that this engine leaves out, each named when a program asks for it.

docs/embedded_engine.md lists them.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from archo_tui.embedded.reexported import REEXPORTED, home_of

MODULES = {
    f"rclpy.{name}"
    for name in (
        "experimental",
        "guard_condition",
        "parameter_event_handler",
        "qos_overriding_options",
        "service_introspection",
        "subscription_content_filter_options",
        "type_description_service",
        "type_hash",
        "wait_for_message",
        "waitable",
    )
}
NAMES: dict[str, tuple[str, ...]] = {  # Missing names of modules that exist here.
    "rclpy.clock": ("ClockChange", "JumpHandle", "JumpThreshold", "TimeJump"),
    "rclpy.event_handler": (
        "QoSEventHandler",
        "QoSLivelinessChangedInfo",
        "QoSLivelinessLostInfo",
        "QoSOfferedDeadlineMissedInfo",
        "QoSRequestedDeadlineMissedInfo",
    ),
    "rclpy.logging": ("initialize", "shutdown"),
    "rclpy.signals": (
        "SignalHandlerGuardCondition",
        "get_current_signal_handlers_options",
        "install_signal_handlers",
        "uninstall_signal_handlers",
    ),
    "rclpy.qos": ("QoSCompatibility", "qos_check_compatible"),
}


def message(name: str) -> str:
    """Return the error text that says that only real ROS 2 has `name`."""
    return f"the embedded engine has no {name}: real ROS 2 has it (archo-tui --engine ros2)"


def check_module(name: str) -> None:
    """Raise ImportError if `name` is a module or package of rclpy that the engine leaves out.

    A submodule of such a package passes: Python imports the package first, which is refused.
    """
    if name in MODULES:
        raise ImportError(message(name), name=name)


def answers_for(module: str) -> bool:
    """Return True if a module of rclpy re-exports names, or lacks some that are in rclpy."""
    return module in REEXPORTED or module in NAMES


def lookup_in(module: str) -> Callable[[str], Any]:
    """Return the `__getattr__` for the module of that full name.

    The function returns what the module re-exports. It raises ImportError for a name that the
    engine leaves out, and AttributeError for any other name.
    """

    def lookup(name: str) -> Any:
        home, made_as = home_of(module, name)
        if home:
            return getattr(importlib.import_module(home), made_as)
        if name in NAMES.get(module, ()):
            raise ImportError(message(f"{module}.{name}"))
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return lookup


class Attribute:
    """A class attribute that the engine leaves out: reading it of an object raises AttributeError.

    Read of the class itself, the attribute is None.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: object, owner: type) -> None:
        if instance is not None:
            raise AttributeError(message(self._name))


def check_arguments(function: str, **given: object) -> None:
    """Raise NotImplementedError, which names the first given argument that is not None.

    Args:
        function: The name of the called function, for the error.
        **given: The arguments that the engine leaves out, by name.
    """
    for name, value in given.items():
        if value is not None:
            raise NotImplementedError(message(f"{function}({name}=...)"))
