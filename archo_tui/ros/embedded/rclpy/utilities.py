"""The module `rclpy.utilities`: the default context."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rclpy import _arguments, _process
from rclpy.context import Context


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the context that is meant if none is given, made when there is none."""
    process = _process.current()
    with process.lock:
        context = process.default_context or Context()
        process.default_context = None if shutting_down else context
        return context


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """Return the arguments that are not ROS's; None means those in `sys.argv`.

    ROS arguments are parsed, and parameter files that they name are read, to find errors.
    """
    given = sys.argv if args is None else args
    _arguments.parse(given)
    return _arguments.split(given)[0]


def ok(*, context: Context | None = None) -> bool:
    """Return True if the context, by default the default one, has begun and is not shut down."""
    return (context or get_default_context()).ok()


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """Shut a context down; raise RuntimeError if it has not begun, or has ended.

    Without a `context`, the default one is shut down and forgotten: the next one asked for is new.
    The global executor is shut down in any case, and not only with its own context as in rclpy.
    """
    (context or get_default_context(shutting_down=True)).shutdown()
    _reset_executor()


def try_shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """Shut a context down as `shutdown` does, if it has begun and not ended."""
    (context or get_default_context(shutting_down=True)).try_shutdown()
    _reset_executor()


def _reset_executor() -> None:
    process = _process.current()
    if process.executor is not None:
        process.executor.shutdown(0)
        process.executor = None


def timeout_sec_to_nsec(timeout_sec: float | None) -> int:
    """Return a timeout in ns; -1, which means no limit, for None and for a negative one."""
    return -1 if timeout_sec is None or timeout_sec < 0 else int(timeout_sec * 1e9)


def get_available_rmw_implementations() -> set[str]:
    """Return the names of the middlewares that can be used: here only "embedded"."""
    return {get_rmw_implementation_identifier()}


def get_rmw_implementation_identifier() -> str:
    """Return "embedded": there is no middleware, since messages stay in the process."""
    return "embedded"
