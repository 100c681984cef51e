"""The clients of the robot: who requests something here, other consoles, and other programs."""

from __future__ import annotations

import itertools
import os
import re
import socket
from asyncio import Future
from collections import deque
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, NamedTuple

from archo_tui.base.system import user_name
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.readings import Motion
from archo_tui.ros.names import base_name

ASSISTANT = "assistant"  # The beginning of an assistant's source.


class Requester:
    """A person or a program that requests something, as events and journal name it."""

    def __init__(self, level: str, source: str) -> None:
        self.level, self.source = level, source  # Of its events: `SHELL` and `pid 4711`.
        # Futures for the outcomes of the goals that it requested.
        self.ends: list[Future[Outcome]] = []
        self.goal: Goal | None = None  # The last of these goals that ended; None if none has.
        # True once it has gone: nothing more is sent for it, and what waits for an approval is
        # dropped.
        self.has_left = False
        # True if it waits for the end of its goals, which are cancelled if it leaves.
        self.waits = False

    @property
    def is_assistant(self) -> bool:
        """True for a program through which a language model sends requests."""
        return self.source.startswith(ASSISTANT)


YOU = Requester("YOU", "console")
_current: ContextVar[Requester] = ContextVar("current_requester", default=YOU)


def current_requester() -> Requester:
    """Return the requester of the present work; the person at the console by default."""
    return _current.get()


@contextmanager
def on_behalf_of(requester: Requester) -> Iterator[None]:
    """Make a requester the current one inside the `with` block, and in tasks that begin there."""
    token = _current.set(requester)
    try:
        yield
    finally:
        _current.reset(token)


# Consoles.

PREFIX = "_archo_console_"
_LONGEST = 200  # Characters; rclpy accepts 255.
_numbers = itertools.count(1)


def new_node_name() -> str:
    """Return a new name for a console's node: `_archo_console_USER_HOST_PROCESS`, `..._2`."""
    number = next(_numbers)
    more = f"_{number}" if number > 1 else ""
    name = f"{PREFIX}{user_name()}_{socket.gethostname()}_{os.getpid()}{more}"
    return re.sub(r"_*[^A-Za-z0-9_]+_*", "_", name)[:_LONGEST]


def author(node: str) -> str:
    """Return the name of the console whose node this is: `anna_lab_4711`; "" for any other node."""
    last = base_name(node)
    return last.removeprefix(PREFIX) if last.startswith(PREFIX) else ""


# Other programs.

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
    """The changes of the robot, compared with what all consoles report to have done."""

    def __init__(self) -> None:
        self._records: deque[tuple[AuditRecord, float]] = deque(maxlen=_MAX_RECORDS)
        self._changes: list[_Change] = []
        self._motion = Motion()
        self.author = CLIENT

    def on_audit_record(self, record: AuditRecord, now: float) -> None:
        """Record what a console reports to have done; what was not sent explains nothing."""
        if record.code not in _NOT_DONE:
            self._records.append((record, now))

    def on_motion(self, motion: Motion, now: float) -> None:
        """Record that the robot was stopped or released since the last message."""
        before, self._motion = self._motion, motion
        if now - (before.received or 0.0) > _GAP:
            return  # Another node may publish it by now.
        if before.stopped is False and motion.stopped:
            self._changes.append(_Change(("stop", "call"), f"stopped by {self.author}", now))
        if before.stopped and motion.stopped is False:
            text = f"stop released by {self.author}"
            self._changes.append(_Change(("release", "call"), text, now))

    def on_parameter(self, node: str, name: str, old: Any, new: Any, now: float) -> None:
        """Record that a node reports a new value of a parameter."""
        change = f"{text_of(new)}, was {text_of(old)}"
        text = f"{node.lstrip('/')} {name} changed by {self.author}: {change}"
        self._changes.append(_Change(("set",), text, now, node, name))

    def take_due(self, now: float) -> list[str]:
        """Return a line for each change of 4 s ago or more that nobody has reported, once."""
        due = [change for change in self._changes if now - change.at >= _PATIENCE]
        self._changes = [change for change in self._changes if now - change.at < _PATIENCE]
        return [change.text for change in due if not self._is_reported(change)]

    def _is_reported(self, change: _Change) -> bool:
        return any(
            -_PATIENCE <= change.at - at <= (_LATE if record.code is Code.TIMEOUT else _PATIENCE)
            and change.may_be_by(record)
            for record, at in self._records
        )
