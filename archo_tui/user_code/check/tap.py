"""The rows of checks in TAP (https://testanything.org)."""

from __future__ import annotations

from collections.abc import Callable

from archo_tui.base.safe_text import safe


class Failed(Exception):
    """The failure of a check: what is wrong, where, and what to do, in lines."""


class Skipped(Exception):
    """The reason why there is nothing to check."""


class Report:
    """A printer of checks: a line `ok` or `not ok` each, with hints below the latter."""

    def __init__(self, print_line: Callable[[str], None]) -> None:
        self._print_line = print_line
        self._count = 0
        self.has_failed = self.has_checked = False

    def check(self, title: str, check: Callable[[], str | None]) -> None:
        """Run a check, which raises Failed or Skipped, and print its row.

        One that passes may return another title, which claims less, or what was seen.
        """
        verdict, hint, why = "ok", "", ""
        try:
            title = check() or title
        except Failed as error:
            verdict, hint = "not ok", str(error)
        except Skipped as error:
            why = f" # SKIP {safe(str(error))}"
        except KeyboardInterrupt:
            self._print_row("Bail out! interrupted")
            raise
        self.has_failed |= verdict == "not ok"
        self.has_checked |= not why
        self._print_row(f"{verdict} {self._count + 1} - {title}{why}")
        for line in hint.splitlines():
            self._print_line(f"# {safe(line)}")

    def _print_row(self, row: str) -> None:
        if not self._count:
            self._print_line("TAP version 13")
        self._count += 1
        self._print_line(row)

    def fail(self, text: str) -> None:
        """Let the checks as a whole fail, for a reason that is none of a row."""
        self.has_failed = True
        self._print_line(f"# {text}")

    def end(self) -> int:
        """Print the last line, and return the exit code: 0 if a check passed and none failed."""
        self._print_line(f"1..{self._count}")
        return 0 if self.has_checked and not self.has_failed else 1
