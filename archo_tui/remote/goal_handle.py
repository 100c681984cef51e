"""The handle of a goal that a Python program has sent through a console."""

from __future__ import annotations

import threading
from typing import Any

from archo_tui.remote.api_errors import (
    ERRORS,
    NotDone,
    RanOut,
    Unconfirmed,
    Unreached,
    checked_timeout,
    data_or_raise,
)
from archo_tui.remote.api_request import Request
from archo_tui.remote.api_status import Goal, from_reply
from archo_tui.remote.protocol import GONE

CANCEL_TIMEOUT = 5.0  # s in which the end of a goal that is called off is confirmed
PARENTS_GOAL = "the goal is of the process that forked this one; the robot may still be moving"


class GoalHandle:
    """A goal that the robot has accepted or that waits in the console's queue; `Robot.go` makes it.

    Several goals of one `go` share a handle; the robot drives them one after the other. Every
    method may be called from any thread.
    """

    def __init__(self, request: Request) -> None:
        self._request = request
        self._is_answered, self._has_ended = threading.Event(), threading.Event()
        self._is_accepted = False
        self._result: dict[str, Any] = {"code": "lost", "text": GONE}
        self._state: Goal | None = None
        threading.Thread(target=self._read_replies, name="goal", daemon=True).start()

    def wait(self, timeout: float | None = None) -> Goal:
        """Wait until the goal has ended, and return it if the robot has arrived.

        Of several goals the last one is returned. An exception that interrupts the wait, such as
        KeyboardInterrupt, cancels the goal.

        Args:
            timeout: Seconds to wait, after which the goal runs on; None: until it has ended.

        Raises:
            Aborted: The goal ended, and the robot has not arrived.
            Cancelled: The goal was cancelled by anybody, or is held in the queue.
            Refused: A goal that waited in the queue was refused when its turn came.
            Unconfirmed: The goal is lost, or the robot does not answer: it may still be moving.
            RanOut: `timeout` seconds passed, and the goal still runs; or the time given to `go` is
                over.
            Unreached: The console has gone or no longer answers: the robot may still be moving.
            Misused: `timeout` is not a valid time; the goal runs on.
        """
        seconds = checked_timeout(timeout)
        try:
            has_ended = self._has_ended.wait(seconds)
        except BaseException:
            self._request.give_up()
            raise
        if not has_ended:
            raise RanOut("ran_out", f"not within {timeout:g} s: the goal still runs")
        return from_reply(Goal, data_or_raise(self._result))

    def cancel(self, timeout: float = CANCEL_TIMEOUT) -> None:
        """Cancel the goal and those behind it in the same `go`, and wait for the end.

        Does nothing once the goal has ended. However it ends, also by arriving, no error is raised.

        Args:
            timeout: Seconds to wait for the end.

        Raises:
            RanOut: The end was not confirmed in that time: the robot may still be moving.
            Unreached: The console has gone or no longer answers: the robot may still be moving.
            Misused: `timeout` is not a valid time; the goal is cancelled all the same.
        """
        self._request.give_up()
        if not self._has_ended.wait(checked_timeout(timeout)):
            raise RanOut("ran_out", "the cancel is not confirmed: the robot may still be moving")
        # It ended for this program only, or nobody knows whether it did.
        if ERRORS.get(self._result["code"]) in (Unreached, Unconfirmed):
            data_or_raise(self._result)

    def feedback(self) -> Goal | None:
        """Return the newest state of the goal, without waiting; None: not reported yet.

        Of several goals it is the one that is driven; after the end, the last one as it ended.
        """
        return self._state

    def done(self) -> bool:
        """Return True once the goal has ended in any way, or the console is unreachable."""
        return self._has_ended.is_set()

    def _leave_to_parent(self) -> None:
        """End the handle in a forked child, which has no thread that reads replies."""
        self._result = {"code": "lost", "text": PARENTS_GOAL}
        # New events: a thread of the parent, which the child lacks, may hold the old ones' locks.
        self._is_answered, self._has_ended = threading.Event(), threading.Event()
        self._is_answered.set()
        self._has_ended.set()

    def _wait_until_accepted(self) -> None:
        """Wait until the robot has accepted the goal, or the console has queued it."""
        self._is_answered.wait()
        if not self._is_accepted:
            data_or_raise(self._result)

    def _read_replies(self) -> None:
        try:
            for reply in self._request.replies():
                if "goal" in reply:
                    self._state = from_reply(Goal, reply["goal"])
                elif "code" in reply:
                    self._result = reply
                    if reply.get("data"):
                        self._state = from_reply(Goal, reply["data"])
                elif "said" in reply:
                    self._is_accepted = True
                    self._is_answered.set()
        except NotDone as error:
            self._result = {"code": error.code, "text": str(error)}
        finally:
            self._has_ended.set()
            self._is_answered.set()
            self._request.close()
