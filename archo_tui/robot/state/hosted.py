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

    @property
    def is_running(self) -> bool:
        """True for UP and STARTING: the node can be stopped and not be started."""
        return self in (Life.UP, Life.STARTING)


class Hosted(NamedTuple):
    """A node that this process hosts.

    Recordings have the names of the attributes.
    """

    name: str
    life: Life = Life.UP  # Its state.
    error: str = ""  # What a callback raised.
    traceback: str = ""  # The traceback of `error`, or "".
    serves: tuple[str, ...] = ()  # The full names of the services and actions that it serves.
    file: str = ""  # The name of the user's file that it comes from; "" for a node of a package.
    saved: float = 0.0  # The Unix time at which the text that runs was saved.
