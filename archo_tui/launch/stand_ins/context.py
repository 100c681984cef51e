"""The state of an evaluation: what launch keeps, and the programs and notes so far."""

from __future__ import annotations

import os
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any, NamedTuple

from archo_tui.launch.stand_ins.places import Place


class Delayed(NamedTuple):
    """The actions of a timer; objects sort by their time, then by their number."""

    time: float  # Seconds after the start.
    number: int
    actions: Iterable[Any]
    local_values: dict[str, Any]  # The `locals` of the context when the timer began.


class LaunchContext:
    """The state that actions read and change: launch configurations, environment, results."""

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = True) -> None:
        self.argv = list(argv or ())
        # As ThisLaunchFile reads them; empty before the file is performed.
        self.locals = SimpleNamespace()
        self.programs: list[dict[str, Any]] = []  # As LaunchedProgram has them.
        self.notes: list[dict[str, Any]] = []  # As LaunchNote has them.
        self.delayed: list[Delayed] = []  # A heap.
        self.time = 0.0  # Seconds after the start that the evaluation has reached.
        # An argument that is given and neither declared nor read gets a note.
        self.read: set[str] = set()
        self.failed_at: Place | None = None  # The line of the action that raised an error.
        self._configurations: dict[str, Any] = {}
        self._environment = dict(os.environ)
        self._pushed_configurations: list[dict[str, Any]] = []
        self._pushed_environments: list[dict[str, str]] = []

    @property
    def launch_configurations(self) -> dict[str, Any]:
        """The launch configurations of the innermost scope, which callers may change in place."""
        return self._configurations

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables of the innermost scope, which callers may change in place."""
        return self._environment

    def perform_substitution(self, substitution: Any) -> str:
        text: str = substitution.perform(self)
        return text

    def push_configurations(self) -> None:
        # A shallow copy, as launch makes it: lists in it are shared with the scope around.
        self._pushed_configurations.append(dict(self._configurations))

    def pop_configurations(self) -> None:
        self._configurations = self._pushed_configurations.pop()

    def push_environment(self) -> None:
        self._pushed_environments.append(dict(self._environment))

    def pop_environment(self) -> None:
        self._environment = self._pushed_environments.pop()

    def reset_environment(self) -> None:
        self._environment = dict(os.environ)

    def changed_environment(self) -> dict[str, str | None]:
        """Return the variables of the innermost scope that differ; None for one that is unset."""
        now = self._environment
        changed: dict[str, str | None] = {
            name: value for name, value in now.items() if os.environ.get(name) != value
        }
        return changed | dict.fromkeys(os.environ.keys() - now.keys())

    def note(self, place: Place, text: str, level: str = "WARN") -> None:
        self.notes.append({"file": place.file, "line": place.line, "level": level, "text": text})
