"""How a check ended, and the lines for it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from archo_tui.robot.text import safe


class Result(NamedTuple):
    """How one check ended; without `hint` it passed."""

    name: str
    hint: str = ""  # what is wrong, where, what to do; a line each
    skipped: str = ""  # why there was nothing to check

    def lines(self, number: int) -> Iterator[str]:
        """As TAP has it."""
        if self.skipped:
            yield f"ok {number} - {self.name} # SKIP {safe(self.skipped)}"
        else:
            yield f"{'not ok' if self.hint else 'ok'} {number} - {self.name}"
        for line in self.hint.splitlines():
            yield f"# {safe(line)}"
