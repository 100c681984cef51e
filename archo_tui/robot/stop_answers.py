"""The answers of all servers to one STOP, and what they come to. Pure.

One call of a service reaches every server of its name, and each answers; a client cannot choose.
The robot has been stopped only if all of them say yes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from archo_tui.robot import message_classes
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import StopAnswer

_SAYS_NO_MORE = ("", "done", "ok", "stop", "stopped", "success")  # Texts of a plain confirmation.


class StopResult(NamedTuple):
    """The result of one call of STOP.

    Attributes:
        outcome: For whoever sent the STOP.
        answer: What the banner shows while the STOP is not confirmed; AWAITED if it is confirmed.
        why: Details of `answer` for the banner, behind its word; "" if there are none.
    """

    outcome: Outcome
    answer: StopAnswer = StopAnswer.AWAITED
    why: str = ""


def not_sent(code: Code, reason: str) -> StopResult:
    """Return the result of a STOP that could not be sent."""
    return StopResult(Outcome(code, reason), StopAnswer.NOT_SENT, f"({reason})")


def result_of(answers: list[Any], servers: int, wait: float) -> StopResult:
    """Return what the answers of all servers to one call of STOP come to.

    The STOP is confirmed (DONE) only if every server says yes. Otherwise a refusal of one server
    counts first (REFUSED), then a missing answer (TIMEOUT), then an answer that is neither yes nor
    no (NOT_CONFIRMED). Of several texts, the first one is told.

    Args:
        answers: Responses of the service, in the order in which they came.
        servers: The number of servers that were asked.
        wait: Seconds for which the answers were awaited.
    """
    read = [(answer, message_classes.outcome_of(answer)) for answer in answers]
    refusals = [outcome.text for answer, outcome in read if message_classes.refuses(answer)]
    of = f" by {len(refusals)} of {servers}" if servers > 1 else ""
    if refusals:
        outcome = Outcome(Code.REFUSED, f"REFUSED{of}: {refusals[0]}")
        return StopResult(outcome, StopAnswer.REFUSED, f"{of} ({refusals[0]})".lstrip())
    if len(answers) < servers:
        if servers == 1:
            return StopResult(Outcome(Code.TIMEOUT, f"no answer in {wait:g} s"), StopAnswer.NONE)
        counted = f"{len(answers)} of {servers} answered"
        outcome = Outcome(Code.TIMEOUT, f"{counted} in {wait:g} s")
        return StopResult(outcome, StopAnswer.NONE, f"from all ({counted})")
    unclear = next((outcome for _, outcome in read if not outcome.ok), None)
    if unclear is not None:
        return StopResult(unclear, StopAnswer.UNCONFIRMED)
    return StopResult(Outcome(Code.DONE, _confirmation(read[0][1].text)))


def _confirmation(text: str) -> str:
    """Return "confirmed", with the robot's own text if that says more."""
    return "confirmed" if text.lower().rstrip(".!") in _SAYS_NO_MORE else f"confirmed: {text}"
