"""The outcome of a command: a code for programs, and a text for people."""

from __future__ import annotations

from enum import Enum
from typing import Any, NamedTuple

from archo_tui.robot.messages.types import kinds

SLOW_CALL = 2.0  # Seconds after which a call without an answer is reported as running.
CALL_WAIT = 30.0  # Seconds to wait for the answer to `call SERVICE`.
# The text for a request for which nobody waits any more.
NOT_TAKEN_BACK = "waiting no longer: the robot may still do it"
WATCHING = "watching only: start archo-tui without --watch to operate the robot"


class Code(str, Enum):
    """The code of an outcome. Other programs rely on the words, so they never change."""

    DONE = "done"
    ACCEPTED = "accepted"  # A goal, whose end is reported later.
    ARRIVED = "arrived"
    REFUSED = "refused"  # By the robot, or because it is not possible now.
    ABORTED = "aborted"
    CANCELLED = "cancelled"  # Or not sent at all: a STOP came after it, or the console ends.
    HELD = "held"  # It waits, and a person must let it go on.
    TIMEOUT = "timeout"  # No answer: it may have been done, or be done later.
    NOT_OFFERED = "not_offered"  # No node offers it.
    NOT_CONFIRMED = "not_confirmed"  # The answer says neither yes nor no.
    WATCHING = "watching"
    MISUSE = "misuse"  # The input is not valid; nothing was sent.
    # Of what a client of the console requests.
    RAN_OUT = "ran_out"  # The client's own time is over.
    LOST = "lost"  # The console ends or restarts, and keeps the goal.
    # Of what an assistant asks for.
    ASKED = "asked"  # A person has to decide.
    DENIED = "denied"
    EXPIRED = "expired"
    VOID = "void"


_GOOD = (Code.DONE, Code.ACCEPTED, Code.ARRIVED)


class Outcome(NamedTuple):
    """The outcome of a command: its code, and a text that says why."""

    code: Code
    text: str

    @property
    def ok(self) -> bool:
        """True if the command succeeded as far as is known by now: DONE, ACCEPTED or ARRIVED."""
        return self.code in _GOOD


class Answer(Outcome):
    """The outcome of a call that was answered."""

    message: Any  # The answer.

    @classmethod
    def of(cls, outcome: Outcome, message: Any) -> Answer:
        """Return an outcome with the same code and text, and with the answer."""
        made = cls(*outcome)
        made.message = message
        return made


class Report(Outcome):
    """An outcome with data for programs: what a verb found out, or how a goal ended."""

    data: Any  # What the text says, in types that JSON has.

    @classmethod
    def of(cls, text: str, data: Any, code: Code = Code.DONE) -> Report:
        """Return an outcome with a text for people, and data for programs."""
        made = cls(code, text)
        made.data = data
        return made


def data_of(outcome: Outcome) -> Any:
    """Return the data of a report; None for any other outcome."""
    return outcome.data if isinstance(outcome, Report) else None


def answer_of(outcome: Outcome) -> Any:
    """Return the answer in an outcome; None if it has none."""
    return outcome.message if isinstance(outcome, Answer) else None


def _verdict_and_words(answer: Any) -> tuple[str, str]:
    """Return the names of `success` or the only bool, and `message` or the only string."""
    found = kinds(answer)
    bools = [name for name, kind in found.items() if kind == "boolean"]
    texts = [name for name, kind in found.items() if kind == "string"]
    verdict = "success" if "success" in bools else bools[0] if len(bools) == 1 else ""
    words = "message" if "message" in texts else texts[0] if len(texts) == 1 else ""
    return verdict, words


def refuses(answer: Any) -> bool:
    """Return True if a service's answer says no."""
    verdict, _ = _verdict_and_words(answer)
    return bool(verdict) and not getattr(answer, verdict)


def says_more(answer: Any) -> bool:
    """Return True if a service's answer has other fields than its verdict and its message."""
    return bool(set(kinds(answer)) - set(_verdict_and_words(answer)))


def outcome_of(answer: Any) -> Outcome:
    """Return what a service's answer means; NOT_CONFIRMED if it says neither yes nor no."""
    verdict, words = _verdict_and_words(answer)
    if not verdict:
        return Outcome(Code.NOT_CONFIRMED, "answered, not confirmed")
    done, text = bool(getattr(answer, verdict)), getattr(answer, words, "")
    code = Code.DONE if done else Code.REFUSED
    return Outcome(code, text if isinstance(text, str) and text else ("done" if done else "failed"))
