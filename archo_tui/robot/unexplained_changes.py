"""Changes of the robot that no console reports: another client made them. No input or output."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.outcome import Code
from archo_tui.robot.state import Motion
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import RobotFile

CLIENT, CONSOLE = "another client", "another console"
# Seconds between a change and the report of the console that made it, before or after; a STOP
# waits 3 s for its servers before it is reported.
_PATIENCE = 4.0
_LATE = 20.0  # Seconds in which a request that was not answered in time may still be carried out.
_GAP = 2.0  # Seconds of silence after which the robot's node may have been restarted.
_MAX_RECORDS = 200  # Reports that are kept.
# Codes of requests that did not reach the robot. REFUSED is not among them: the robot may have done
# a part, as when one of two servers stops.
_NOT_DONE = (Code.CANCELLED, Code.HELD, Code.NOT_OFFERED, Code.WATCHING, Code.MISUSE)


class _Change(NamedTuple):
    """A change of the robot that was seen.

    Attributes:
        verbs: The verbs that may have caused it.
        text: The line for the event.
        at: When it was seen, in monotonic seconds.
        node: The full name of the node whose parameter changed; "" for another change.
        parameter: The name of that parameter; "" for another change.
    """

    verbs: Collection[str]
    text: str
    at: float
    node: str = ""
    parameter: str = ""

    def may_be_by(self, verbs: Collection[str], arguments: Mapping[str, Any]) -> bool:
        if not set(verbs) & set(self.verbs):
            return False
        values = arguments.get("values")
        is_named = isinstance(values, Mapping) and self.parameter in values
        return not self.node or (arguments.get("node") == self.node and is_named)


class UnexplainedChanges:
    """The changes of the robot, compared with what all consoles, this one too, report to have done.

    Attributes:
        author: The author of a change that no console reports, as events name it: CLIENT, or what
            others set.
    """

    def __init__(self, commands: Collection[str], services: Mapping[str, Collection[str]]) -> None:
        """Begin without changes.

        Args:
            commands: The verbs for the commands of the robot file, any of which may zero the count.
            services: The verbs that call a service, by the service's full name: `call` may have
                the same effect. One service may stop and release, depending on its request.
        """
        self._commands, self._services = commands, services
        self._records: deque[tuple[AuditRecord, float]] = deque(maxlen=_MAX_RECORDS)
        self._changes: list[_Change] = []
        self._motion = Motion()
        self.author = CLIENT

    @classmethod
    def of_robot(cls, file: RobotFile, full_name: Callable[[str], str]) -> UnexplainedChanges:
        """Create the comparison with the verbs that a robot file's commands and STOP stand for.

        Args:
            file: The robot file.
            full_name: Returns the full name of a service in the file.
        """
        commands = {
            word for command in file.commands for word in (command.id, command.off_word) if word
        }
        called = [(command.service, command.id) for command in file.commands]
        if file.stop is not None:
            called += [(file.stop.service, "stop"), (file.stop.release, "release")]
        services: dict[str, list[str]] = {}
        for service, verb in called:
            if service:
                services.setdefault(full_name(service), []).append(verb)
        return cls(commands, services)

    def on_audit_record(self, record: AuditRecord, now: float) -> None:
        """Record what a console reports to have done; requests that were not sent explain nothing.

        Only the last `_MAX_RECORDS` reports are kept.

        Args:
            record: The report.
            now: Monotonic time in seconds.
        """
        if record.code not in _NOT_DONE:
            self._records.append((record, now))

    def on_motion(
        self, motion: Motion, now: float, is_restarted: Callable[[], bool] = lambda: False
    ) -> None:
        """Record the changes between a message about the motion and the one before.

        Changes are a stop, a release, and a count that became zero. After a silence of more than 2
        s, or if `is_restarted`, nothing counts as a change.

        Args:
            motion: What was received.
            now: Monotonic time in seconds.
            is_restarted: Returns True if another node publishes the motion than before, whose first
                values are no changes; called only if something changed.
        """
        before, self._motion = self._motion, motion
        if now - (before.received or 0.0) > _GAP:
            return  # Another node may publish it by now.
        changes = []
        if before.stopped is False and motion.stopped:
            changes.append(_Change(("stop",), f"stopped by {self.author}", now))
        if before.stopped and motion.stopped is False:
            changes.append(_Change(("release",), f"stop released by {self.author}", now))
        if before.count and motion.count == 0:
            text = f"encoder reset by {self.author}: 0, was {before.count}"
            changes.append(_Change(self._commands, text, now))
        if changes and not is_restarted():
            self._changes += changes

    def on_parameter(self, node: str, name: str, old: Any, new: Any, now: float) -> None:
        """Record that a node reports a new value of a parameter.

        Args:
            node: The full name of the node.
            name: The name of the parameter.
            old: The value before.
            new: The present value.
            now: Monotonic time in seconds.
        """
        change = f"{text_of(new)}, was {text_of(old)}"
        text = f"{node.lstrip('/')} {name} changed by {self.author}: {change}"
        self._changes.append(_Change(("set",), text, now, node, name))

    def take_due(self, now: float) -> list[str]:
        """Remove changes that are at least 4 s old; return a line for each that nobody reported.

        Args:
            now: Monotonic time in seconds.
        """
        due = [change for change in self._changes if now - change.at >= _PATIENCE]
        self._changes = [change for change in self._changes if now - change.at < _PATIENCE]
        return [change.text for change in due if not self._is_reported(change)]

    def _is_reported(self, change: _Change) -> bool:
        return any(
            -_PATIENCE <= change.at - at <= (_LATE if record.code == Code.TIMEOUT else _PATIENCE)
            and change.may_be_by(self._verbs(record), record.arguments)
            for record, at in self._records
        )

    def _verbs(self, record: AuditRecord) -> Collection[str]:
        """Return the verb of a report; for `call`, those that call the same service, if any do."""
        service = record.arguments.get("service")
        if record.verb != "call" or not isinstance(service, str):
            return (record.verb,)
        return self._services.get(service, (record.verb,))
