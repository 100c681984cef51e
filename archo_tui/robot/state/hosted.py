"""A node that this process hosts."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class Life(Enum):
    """The state of a hosted node, or of a program that the console runs."""

    UP = "up"
    STOPPED = "stopped by you"
    CRASHED = "crashed"
    STUCK = "does not stop"
    STARTING = "starting"  # Its constructor has not returned.
    ENDED = "ended"  # Its program has returned.
    WAITING = "waits: release the STOP, then s"  # A program that was to start behind a STOP.

    @property
    def is_running(self) -> bool:
        """True for UP and STARTING: the node can be stopped and not be started."""
        return self in (Life.UP, Life.STARTING)


class Hosted(NamedTuple):
    """A node that this process hosts.

    Recordings have the names of the attributes.

    Attributes:
        name: Its full name.
        life: Its state.
        error: What a callback raised; for a node that is UP, why the changed text of its file does
            not run; for one that is STARTING, the line where its constructor is. "" if there is
            none.
        traceback: The traceback of `error`, or "".
        serves: The full names of the services and actions that it serves.
        file: The name of the user's file that it comes from; "" for a node of a package.
        saved: The Unix time at which the text that runs was saved.
    """

    name: str
    life: Life = Life.UP
    error: str = ""
    traceback: str = ""
    serves: tuple[str, ...] = ()
    file: str = ""
    saved: float = 0.0
