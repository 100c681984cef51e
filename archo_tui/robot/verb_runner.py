"""The running of verbs: on the ROS thread, within a deadline, each with a report of its end."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.events import Reporter
from archo_tui.robot.outcome import WATCHING, Answer, Code, Outcome, answer_of
from archo_tui.robot.requester import current_requester
from archo_tui.robot.ros_thread import RosThread
from archo_tui.robot.snapshot_sender import SnapshotSender
from archo_tui.robot.state import Event
from archo_tui.robot.stop.gate import NOT_SENT, Gate, Stops, Void
from archo_tui.robot.stop_sender import ALL_ANSWERS, FIRST_FOUND
from archo_tui.safe_text import harmless

# Seconds: more than any verb takes that can still end. STOP waits for a server, and then for all.
_DEADLINE = FIRST_FOUND + ALL_ANSWERS + 1.0


class VerbRunner:
    """The runner of verbs: on the ROS thread, each with a report. Called on the event loop."""

    def __init__(
        self,
        thread: RosThread,
        clock: Clock,
        stops: Stops,
        reporter: Reporter,
        snapshots: SnapshotSender,
        *,
        watching: bool,
    ) -> None:
        self._thread, self._clock, self._stops = thread, clock, stops
        self._reporter, self._snapshots, self._watching = reporter, snapshots, watching

    async def run(
        self,
        verb: str,
        arguments: Mapping[str, Any],
        title: str,
        command: str,
        work: Callable[[Gate], Coroutine[Any, Any, Outcome]],
        wait: float = 0.0,
    ) -> Outcome:
        """Run a verb, report how it ended, send a snapshot that shows it, and return its outcome.

        The report is an event, a line of the ROS log and an audit record for other consoles. Errors
        become outcomes: `Void` CANCELLED, another exception REFUSED.
        """
        if self._watching:
            return Outcome(Code.WATCHING, WATCHING)
        self._stops.superseded |= verb != "stop"
        gate, requester = self._stops.gate(), current_requester()

        def report(outcome: Outcome) -> Outcome:
            answer, outcome = answer_of(outcome), Outcome(outcome.code, harmless(outcome.text))
            record = AuditRecord(verb, arguments, outcome.code)
            self._reporter.report_done(f"{title}: {outcome.text}", record, command, requester)
            self._snapshots.send()
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
            return await self._thread.run(there, deadline)
        except TimeoutError:
            text = f"no answer in {deadline:g} s from the console's own node"
            outcome = Outcome(Code.TIMEOUT, text)
            event = Event(
                self._clock.now(),
                requester.level,
                requester.source,
                f"{title}: {outcome.text}",
                command,
                audit_record=AuditRecord(verb, arguments, outcome.code),
            )
            self._thread.submit(lambda: self._reporter.add(event))
            return outcome

    def late_report(
        self, title: str, verb: str, arguments: Mapping[str, Any] | None = None
    ) -> Callable[[Outcome], None]:
        """Return a function that reports the outcome of an answer for which nobody waits any more.

        The report names the present requester. Call the function on the ROS thread.
        """
        requester = current_requester()

        def report(outcome: Outcome) -> None:
            record = AuditRecord(verb, arguments or {}, outcome.code)
            text = f"{title}, answered late: {harmless(outcome.text)}"
            self._reporter.report_done(text, record, requester=requester)

        return report
