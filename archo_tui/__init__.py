"""archo-tui: an interactive terminal console for the warehouse robot ARCHO."""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from archo_tui.client.errors import (
        Aborted,
        Cancelled,
        Misused,
        NotDone,
        RanOut,
        Refused,
        Unconfirmed,
        Unreached,
    )
    from archo_tui.client.robot import GoalHandle, Robot
    from archo_tui.client.state import Goal, Status

__all__ = [
    "Aborted",
    "Cancelled",
    "Goal",
    "GoalHandle",
    "Misused",
    "NotDone",
    "RanOut",
    "Refused",
    "Robot",
    "Status",
    "Unconfirmed",
    "Unreached",
    "__version__",
    "connect",
    "stop",
]
__version__ = "0.2.0"

if sys.version_info < (3, 10):  # noqa: UP036  # pip sees to it, but nobody asks pip to run a .pyz
    found = ".".join(map(str, sys.version_info[:2]))
    sys.stderr.write("archo-tui: needs Python 3.10 or newer, this is " + found + "\n")
    sys.exit(2)


def connect(to: str = "") -> Robot:
    """Return the robot of the console that runs here: `with archo_tui.connect() as robot: ...`.

    If several consoles could be meant, or one of them does not answer, none is chosen: an error is
    raised. It takes 1 s at most.

    Args:
        to: The process, the namespace or the socket's name of one among several consoles: `4711`,
            `/north`. Empty: the variable ARCHO_TUI_CONSOLE, else the only one.

    Returns:
        The robot. Its methods may be called from any thread; leaving its `with` block cancels the
        goals that it has sent and that still run.

    Raises:
        Unreached: No console runs, several do, or one that could be meant does not answer. All
            errors are in `archo_tui`: NotDone is their base, its subclasses Refused, Unconfirmed,
            Misused, Aborted, Cancelled, RanOut and Unreached.
    """
    from archo_tui.client.robot import Robot

    return Robot(to)


def stop(to: str = "") -> None:
    """Send STOP to every console that could be meant, and wait for the answers.

    It needs no connection: a console that is suspended carries it out when it wakes, and several
    are all stopped, as by `archo-tui stop`. It takes 15 s at most.

    Args:
        to: As in `connect`; empty, without the variable: each console that runs here.

    Raises:
        Unreached: No console runs, or one did not confirm the STOP: its robot may be moving.
        Unconfirmed, Refused: A robot did not confirm the STOP, or refused it.
    """
    from archo_tui.client.robot import stop

    stop(to)


def __getattr__(name: str) -> Any:
    """Return an error or a type of `connect()`, which is imported when it is first named."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from archo_tui.client import errors, robot, state

    modules = robot, errors, state
    return next(getattr(module, name) for module in modules if hasattr(module, name))


def __dir__() -> list[str]:
    """Return the names of the module, those that are not imported yet included."""
    return sorted({*globals(), *__all__})
