"""The errors of `archo_tui.connect()`: one for each way in which a call is not carried out."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.remote import client
from archo_tui.remote.protocol import is_valid_timeout


class NotDone(ArchoError):
    """The base of all errors here: a call did not do what it was asked for.

    Attributes:
        code: How it ended, a word of docs/protocol.md such as `refused`, `misuse` or `aborted`.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


class Refused(NotDone):
    """The robot or the console refused, or did not confirm it."""


class Misused(NotDone):
    """The arguments mean nothing here; nothing was sent."""


class Aborted(NotDone):
    """The goal ended, and the robot has not arrived."""


class Cancelled(NotDone):
    """The goal was cancelled, by whomever, or is held in the queue."""


class RanOut(NotDone):
    """The time given as `timeout` is over."""


class Unreached(NotDone):
    """No console runs, several do, or it does not answer: the robot may still be moving."""


ERRORS: dict[str, type[NotDone]] = {
    "misuse": Misused,
    "aborted": Aborted,
    "cancelled": Cancelled,
    "held": Cancelled,
    "ran_out": RanOut,
    "lost": Unreached,
    "unreached": Unreached,
}
_GOOD = ("done", "accepted", "arrived")


def data_of(result: Mapping[str, Any]) -> Any:
    """Return the data of a result.

    Raises:
        NotDone: As the subclass for its code, unless that is a success.
    """
    code = result["code"]
    if code not in _GOOD:
        raise ERRORS.get(code, Refused)(code, result["text"])
    return result.get("data")


@contextlib.contextmanager
def unreached() -> Iterator[None]:
    """Convert `client.Unreached`, raised inside this context, to the `Unreached` of this module."""
    try:
        yield
    except client.Unreached as error:
        raise Unreached("unreached", str(error)) from None


def checked_timeout(timeout: float | None) -> float | None:
    """Return `timeout` itself.

    Raises:
        Misused: It is neither None nor a valid number of seconds.
    """
    if timeout is not None and not is_valid_timeout(timeout):
        raise Misused("misuse", f"timeout: not a time in s: {str(timeout)[:40]}")
    return timeout
