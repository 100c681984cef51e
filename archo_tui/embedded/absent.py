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
    """Return the error text for a name that only real ROS 2 has."""
    return f"the embedded engine has no {name}: real ROS 2 has it (archo-tui --engine ros2)"


def check_module(name: str) -> None:
    """Raise ImportError when the module, or its package, is left out."""
    if name in MODULES:
        raise ImportError(message(name), name=name)


def answers_for(module: str) -> bool:
    """Return True for a module that re-exports names, or leaves some out."""
    return module in REEXPORTED or module in NAMES


def lookup_in(module: str) -> Callable[[str], Any]:
    """Return the `__getattr__` of a module.

    It returns what the module re-exports, and raises ImportError for what it leaves out.
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
    """An attribute of a class that is left out: reading it from an object raises AttributeError."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: object, owner: type) -> None:
        if instance is not None:
            raise AttributeError(message(self._name))


def check_arguments(function: str, **given: object) -> None:
    """Raise NotImplementedError for an argument of the function that is left out, unless None."""
    for name, value in given.items():
        if value is not None:
            raise NotImplementedError(message(f"{function}({name}=...)"))
