"""The outcome of a check, and its lines in TAP."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from archo_tui.safe_text import safe


class Result(NamedTuple):
    """The outcome of a check.

    Attributes:
        name: The check.
        hint: What is wrong, where, and what to do, in lines; "" if the check passed.
        skipped: Why there was nothing to check; "" if there was.
    """

    name: str
    hint: str = ""
    skipped: str = ""

    def lines(self, number: int) -> Iterator[str]:
        """Yield the outcome as TAP lines."""
        if self.skipped:
            yield f"ok {number} - {self.name} # SKIP {safe(self.skipped)}"
        else:
            yield f"{'not ok' if self.hint else 'ok'} {number} - {self.name}"
        for line in self.hint.splitlines():
            yield f"# {safe(line)}"
