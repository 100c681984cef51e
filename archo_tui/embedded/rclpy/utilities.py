"""`rclpy.utilities`: the default context."""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence

from rclpy import _arguments
from rclpy.context import Context

_lock = threading.Lock()
_default: Context | None = None


def get_default_context(*, shutting_down: bool = False) -> Context:
    """The context that is meant when none is given; `shutting_down`, for the last time."""
    global _default
    with _lock:
        context = _default or Context()
        _default = None if shutting_down else context
        return context


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """The arguments (of the program, if not given) that are not ROS's.

    Raises RCLInvalidROSArgsError and UnknownROSArgsError for those of ROS that cannot be.
    """
    given = sys.argv if args is None else args
    _arguments.parse(given)
    return _arguments.split(given)[0]


def ok(*, context: Context | None = None) -> bool:
    """True when the (default) context is initialised."""
    return (context or get_default_context()).ok()


def shutdown(*, context: Context | None = None) -> None:
    """End the (default) context. Raises RuntimeError when not begun."""
    (context or get_default_context(shutting_down=True)).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """End the (default) context if begun."""
    (context or get_default_context(shutting_down=True)).try_shutdown()


def timeout_sec_to_nsec(timeout_sec: float | None) -> int:
    """A timeout in ns; -1 for None and for a negative one, which never pass."""
    return -1 if timeout_sec is None or timeout_sec < 0 else int(timeout_sec * 1e9)


def get_available_rmw_implementations() -> set[str]:
    """The names of what can be used."""
    return {get_rmw_implementation_identifier()}


def get_rmw_implementation_identifier() -> str:
    """The name of the middleware: there is none, messages stay in the process."""
    return "embedded"
