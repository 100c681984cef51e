"""Changes of the robot that no console reports: another client made them. No input or output."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.readings import Motion
from archo_tui.robot_file.model import RobotFile

CLIENT, CONSOLE = "another client", "another console"
# Seconds between a change and the report of the console that made it, before or after; a STOP
# waits 3 s for its servers before it is reported.
_PATIENCE = 4.0
_LATE = 20.0  # Seconds in which a request that was not answered in time may still be carried out.
_GAP = 2.0  # Seconds of silence after which the robot's node may have been restarted.
_RESTART = 3.0  # Seconds after a restart in which readings may differ because of it.
_MAX_RECORDS = 200  # Reports that are kept.
# Codes of requests that did not reach the robot. REFUSED is not among them: the robot may have done
# a part, as when one of two servers stops.
_NOT_DONE = (Code.CANCELLED, Code.HELD, Code.NOT_OFFERED, Code.WATCHING, Code.MISUSE)


class _Change(NamedTuple):
    verbs: Collection[str]  # Those that may have caused it.
    text: str
    at: float  # Monotonic, s.
    node: str = ""  # Of a parameter that changed, with its name.
    parameter: str = ""

    def may_be_by(self, record: AuditRecord) -> bool:
        if record.verb not in self.verbs:
            return False
        node, values = record.arguments.get("node"), record.arguments.get("values")
        is_named = isinstance(values, dict) and self.parameter in values
        return not self.node or (node == self.node and is_named)


class UnexplainedChanges:
    """The changes of the robot, compared with what all consoles, this one too, report to have done.

    `author` names whoever makes a change that no console reports.
    """

    def __init__(
        self, file: RobotFile, motion_publishers: Callable[[], frozenset[bytes]] = frozenset
    ) -> None:
        self._commands = {"call"} | {
            word for command in file.commands for word in (command.id, command.off_word) if word
        }
        self._publisher_ids = motion_publishers
        self._known_ids: frozenset[bytes] = frozenset()
        self._restarted = float("-inf")  # When the motion got another publisher; monotonic, s.
        self._records: deque[tuple[AuditRecord, float]] = deque(maxlen=_MAX_RECORDS)
        self._changes: list[_Change] = []
        self._motion = Motion()
        self.author = CLIENT

    def on_audit_record(self, record: AuditRecord, now: float) -> None:
        """Record what a console reports to have done; what was not sent explains nothing."""
        if record.code not in _NOT_DONE:
            self._records.append((record, now))

    def on_motion(self, motion: Motion, now: float) -> None:
        """Record a stop, a release, or a count that became zero since the last message.

        The first values of a node that was restarted are no changes.
        """
        before, self._motion = self._motion, motion
        if now - (before.received or 0.0) > _GAP:
            return  # Another node may publish it by now.
        changes = []
        if before.stopped is False and motion.stopped:
            changes.append(_Change(("stop", "call"), f"stopped by {self.author}", now))
        if before.stopped and motion.stopped is False:
            changes.append(_Change(("release", "call"), f"stop released by {self.author}", now))
        if before.count and motion.count == 0:
            text = f"encoder reset by {self.author}: 0, was {before.count}"
            changes.append(_Change(self._commands, text, now))
        if changes and not self._has_restarted(now):
            self._changes += changes

    def on_parameter(self, node: str, name: str, old: Any, new: Any, now: float) -> None:
        """Record that a node reports a new value of a parameter."""
        change = f"{text_of(new)}, was {text_of(old)}"
        text = f"{node.lstrip('/')} {name} changed by {self.author}: {change}"
        self._changes.append(_Change(("set",), text, now, node, name))

    def take_due(self, now: float) -> list[str]:
        """Return a line for each change of 4 s ago or more that nobody has reported, once."""
        self._has_restarted(now)
        due = [change for change in self._changes if now - change.at >= _PATIENCE]
        self._changes = [change for change in self._changes if now - change.at < _PATIENCE]
        return [change.text for change in due if not self._is_reported(change)]

    def _has_restarted(self, now: float) -> bool:
        """Return True if the motion has had other publishers in the last 3 s than before."""
        ids = self._publisher_ids()
        if ids and self._known_ids and ids != self._known_ids:
            self._restarted = now
        self._known_ids = ids or self._known_ids
        return now - self._restarted <= _RESTART

    def _is_reported(self, change: _Change) -> bool:
        return any(
            -_PATIENCE <= change.at - at <= (_LATE if record.code is Code.TIMEOUT else _PATIENCE)
            and change.may_be_by(record)
            for record, at in self._records
        )
