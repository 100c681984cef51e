"""The running of requests: on the ROS thread, within a deadline, each with a report of its end."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from archo_tui.errors import in_one_line
from archo_tui.robot.clients import current_requester
from archo_tui.robot.outcome import WATCHING, Answer, Code, Outcome, answer_of
from archo_tui.robot.parts import Parts
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event
from archo_tui.robot.stop.gate import NOT_SENT, Gate, Void
from archo_tui.robot.stop.sender import ALL_ANSWERS, FIRST_FOUND
from archo_tui.safe_text import harmless

# Seconds: more than any verb takes that can still end. STOP waits for a server, and then for all.
_DEADLINE = FIRST_FOUND + ALL_ANSWERS + 1.0


async def run(
    robot: Parts,
    verb: str,
    arguments: Mapping[str, Any],
    title: str,
    command: str,
    work: Callable[[Gate], Coroutine[Any, Any, Outcome]],
    wait: float = 0.0,
) -> Outcome:
    """Run `work` on the ROS thread, report how it ended, and return its outcome; it never raises.

    The report is an event, a line of the ROS log and an audit record for other consoles. `work`
    passes the gate just before its request is sent, and may take `wait` seconds more than others.
    """
    if robot.watching:
        return Outcome(Code.WATCHING, WATCHING)
    robot.stops.superseded |= verb != "stop"
    gate, requester = robot.stops.gate(), current_requester()

    def report(outcome: Outcome) -> Outcome:
        answer, outcome = answer_of(outcome), Outcome(outcome.code, harmless(outcome.text))
        record = AuditRecord(verb, arguments, outcome.code)
        robot.reporter.report_done(f"{title}: {outcome.text}", record, command, requester)
        robot.snapshots.send()
        return outcome if answer is None else Answer.of(outcome, answer)

    async def there() -> Outcome:
        try:
            return report(await work(gate))
        except Void:
            return report(Outcome(Code.CANCELLED, NOT_SENT))
        except Exception as error:
            return report(Outcome(Code.REFUSED, in_one_line(error)))

    deadline = _DEADLINE + wait
    try:
        return await robot.thread.run(there, deadline)
    except TimeoutError:
        outcome = Outcome(Code.TIMEOUT, f"no answer in {deadline:g} s from the console's own node")
        event = Event(
            *(robot.clock.now(), requester.level, requester.source, f"{title}: {outcome.text}"),
            command,
            audit_record=AuditRecord(verb, arguments, outcome.code),
        )
        robot.thread.submit(lambda: robot.reporter.add(event))
        return outcome


def late_report(
    robot: Parts, title: str, verb: str, arguments: Mapping[str, Any] | None = None
) -> Callable[[Outcome], None]:
    """Return a function that reports an answer for which nobody waits any more."""
    requester = current_requester()

    def report(outcome: Outcome) -> None:
        record = AuditRecord(verb, arguments or {}, outcome.code)
        text = f"{title}, answered late: {harmless(outcome.text)}"
        robot.reporter.report_done(text, record, requester=requester)

    return report
