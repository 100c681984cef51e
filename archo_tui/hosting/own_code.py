"""The code of a user's file, and of what it imports from its folder, as messages name it."""

from __future__ import annotations

import sysconfig
from pathlib import Path
from traceback import StackSummary

import archo_tui
from archo_tui.errors import quoted_line

# Python itself may be in the home folder, beside the user's files.
_PYTHON = Path(sysconfig.get_path("stdlib")).resolve()
_CONSOLE = Path(archo_tui.__file__).resolve().parent  # In a clone, beside the user's files.


class OwnCode:
    """The code of a file and of its folder.

    Attributes:
        path: The path of the file.
    """

    def __init__(self, given: str, path: Path) -> None:
        """Create the description of a file.

        Args:
            given: The file as the user typed it.
            path: The path of the file.
        """
        self._given, self.path = given, path
        self._known: dict[str, bool] = {}  # As each question takes a look at the disk.

    def __str__(self) -> str:
        return self._given

    def is_own(self, filename: str) -> bool:
        """Return True for the file itself, and files in or below its folder, unless installed.

        Python's own library, the console and `site-packages` count as installed.
        """
        if not filename:  # Built-in code has none.
            return False
        if filename not in self._known:
            path = Path(filename).resolve()
            is_installed = "site-packages" in path.parts or not {_PYTHON, _CONSOLE}.isdisjoint(
                path.parents
            )
            is_beside = self.path.parent in path.parents and not is_installed
            self._known[filename] = path == self.path or is_beside
        return self._known[filename]

    def display_name(self, filename: str) -> str:
        """Return the name of a file for people: of this file as typed, of others without folder."""
        path = Path(filename).resolve()
        return self._given if path == self.path else path.name

    def place(self, stack: StackSummary) -> tuple[str, str]:
        """Return the line of the file or its modules that a stack is at.

        Returns:
            `FILE:LINE` of the last frame of the file or its modules, and `, in: x = y + 1` with the
            text of that line; the name of the file and "" if there is no such frame.
        """
        frames = [frame for frame in stack if self.is_own(frame.filename)]
        if not frames:
            return self._given, ""
        last = frames[-1]
        return f"{self.display_name(last.filename)}:{last.lineno}", quoted_line(last.line or "")
