"""An argparse parser whose errors are one line, and whose help keeps indented lines."""

from __future__ import annotations

import argparse
import os

from archo_tui.errors import ArchoError

TYPE_CHECKING = False  # Importing typing takes longer than everything that --help needs.
if TYPE_CHECKING:
    from typing import Any, NoReturn


class OneLineErrorParser(argparse.ArgumentParser):
    """An argument parser that raises an ArchoError of one line where others print and exit."""

    def __init__(self, prog: str, description: str, **more: Any) -> None:
        width = _columns() - 2  # As in argparse, which imports all of shutil for it.
        super().__init__(
            prog=prog,
            description=description,
            allow_abbrev=False,  # A typo is an error, and not another option.
            formatter_class=lambda prog: _Formatter(prog, width=width),
            **more,
        )

    def error(self, message: str) -> NoReturn:
        raise ArchoError(f"{message}{self._nearest(message)} (see {self.prog} --help)")

    def _nearest(self, message: str) -> str:
        """Return `, nearest: --node` for the first option that an error calls unknown, or ""."""
        wrong = message.partition("unrecognized arguments: ")[2].split()
        typed = next((word.partition("=")[0] for word in wrong if word.startswith("--")), "")
        if not typed:
            return ""
        from archo_tui.nearest import nearest

        known = [option for action in self._actions for option in action.option_strings]
        near = nearest(typed, known)
        return f", nearest: {near}" if near else ""


class _Formatter(argparse.HelpFormatter):
    """A help formatter that leaves indented lines of a text unchanged."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines = text.splitlines()
        fill = super()._fill_text
        return "\n".join(
            line if not line or line[0] == " " else fill(line, width, indent) for line in lines
        )


def _columns() -> int:
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and int(columns):
        return int(columns)
    try:
        return os.get_terminal_size(1).columns or 80
    except OSError:
        return 80
