"""The errors of `archo_tui.connect()`: one for each way in which a call is not carried out."""

from __future__ import annotations

from archo_tui.base.errors import ArchoError
from archo_tui.client.protocol import GOOD, timeout_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any


class NotDone(ArchoError):
    """The base of all errors here: a call did not do what was asked for.

    Attributes:
        code: The outcome, a word of docs/protocol.md such as `refused`, `misuse` or `aborted`.
    """

    code = "refused"

    def __init__(self, text: str, code: str = "") -> None:
        super().__init__(text)
        self.code = code or self.code


class Refused(NotDone):
    """The error for a request that the robot or the console refused: nothing was done."""


class Unconfirmed(NotDone):
    """The error for a request without a clear answer, or for a goal that is lost.

    The robot may have done it, or may still do it, and may be moving.
    """

    code = "not_confirmed"


class Misused(NotDone):
    """The error for a call that means nothing here, or after `Robot.close`; nothing was sent."""

    code = "misuse"


class Aborted(NotDone):
    """The error for a goal that ended without the robot arriving."""

    code = "aborted"


class Cancelled(NotDone):
    """The error for a goal that was cancelled by anybody, or is held in the queue."""

    code = "cancelled"


class RanOut(NotDone):
    """The error for a call that did not finish within its `timeout`."""

    code = "ran_out"


class Unreached(NotDone):
    """The error for a console that could not be reached or did not answer.

    No console runs, several could be meant, one does not answer, or `Robot.close` ended the call.
    The robot may still be moving.
    """

    code = "unreached"


ERRORS: dict[str, type[NotDone]] = {
    **{
        error.code: error for error in (Misused, Aborted, Cancelled, RanOut, Unconfirmed, Unreached)
    },
    "held": Cancelled,
    "timeout": Unconfirmed,
    "lost": Unreached,
}


def data_or_raise(result: Mapping[str, Any]) -> Any:
    """Return the `data` of a successful result, None without one; raise any other's error."""
    code = result["code"]
    if code not in GOOD:
        raise ERRORS.get(code, Refused)(result["text"], code)
    return result.get("data")


def checked_timeout(timeout: float | None) -> float | None:
    """Return `timeout` if it is None or from 0 to 1e9 seconds; raise Misused otherwise."""
    try:
        return timeout_of({"timeout": timeout})
    except ValueError as error:
        raise Misused(str(error)) from None
