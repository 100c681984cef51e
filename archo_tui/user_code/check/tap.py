"""The outcome of a check, and its lines in TAP."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from archo_tui.safe_text import safe


class Result(NamedTuple):
    """The outcome of a check."""

    name: str
    hint: str = ""  # The mistake, its place, and what to do, in lines; "" if it passed.
    skipped: str = ""  # Why nothing was checked; "" if something was.

    def lines(self, number: int) -> Iterator[str]:
        """Yield the outcome as TAP lines; `number` is that of the check, from 1."""
        if self.skipped:
            yield f"ok {number} - {self.name} # SKIP {safe(self.skipped)}"
        else:
            yield f"{'not ok' if self.hint else 'ok'} {number} - {self.name}"
        for line in self.hint.splitlines():
            yield f"# {safe(line)}"


class TapReport:
    """The printer of the outcomes of a run of checks as TAP; TAP's header comes before all else."""

    def __init__(self, print_line: Callable[[str], None]) -> None:
        self._print_line = print_line
        self._count = 0
        self._has_begun = False
        self.has_failed = self.has_checked = False

    def show(self, result: Result) -> None:
        """Print the outcome of a check under the next number, and count it in the exit code."""
        self._count += 1
        self.has_failed |= bool(result.hint)
        self.has_checked |= not result.skipped
        for line in result.lines(self._count):
            self._print(line)

    def _print(self, line: str) -> None:
        if not self._has_begun:
            self._has_begun = True
            self._print_line("TAP version 13")
        self._print_line(line)

    def comment(self, text: str) -> None:
        """Print a comment line of TAP."""
        self._print(f"# {safe(text)}")

    def bail_out(self) -> None:
        """Print that the person interrupted the checks, so that the rest is not checked."""
        self._print("Bail out! interrupted")

    def end(self) -> int:
        """Print the last line, and return the exit code: 0 if a check passed and none failed.

        Otherwise, also if all were skipped, the code is 1.
        """
        self._print(f"1..{self._count}")
        return 1 if self.has_failed or not self.has_checked else 0
