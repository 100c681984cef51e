"""A Python file of the user's own that is run in this process, or in a child of it."""

from __future__ import annotations

import contextlib
import importlib.util
import linecache
import sys
from pathlib import Path

from archo_tui.errors import UserFileError
from archo_tui.hosting.own_code import OwnCode
from archo_tui.hosting.source import Source
from archo_tui.hosting.watch import Stamps

OURS = ("archo_tui", "archo_bringup", "rclpy")  # Never reloaded, wherever the file is.


class NodeFileError(UserFileError):
    """The error for a file that cannot be found or run, or a node of it that is not constructed."""


class UserFile:
    """A Python file, by its path or by the dotted name of its module.

    Attributes:
        path: The path of the file, resolved.
        code: The code of the file and of its folder, as messages name it.
        loaded: The stamps of the text that was last loaded, or could not be loaded; empty before.
        source: The syntax tree of the text that was last loaded; an empty one before.
    """

    def __init__(self, given: str) -> None:
        """Find the file, without reading it.

        For a dotted name, the current folder is added to `sys.path`, and the packages above the
        module are imported.

        Args:
            given: Its path, or the dotted name of a module, as the user typed it.

        Raises:
            NodeFileError: There is no such Python file or module.
        """
        self._given = given
        self.path, self._name = _find_file(given)
        self.code = OwnCode(given, self.path)
        self.loaded: Stamps = {}
        self.source = Source(b"")

    def __str__(self) -> str:
        return self._given

    @property
    def saved(self) -> float:
        """The Unix time in seconds at which the file was saved; 0.0 while there is no file."""
        try:
            return self.path.stat().st_mtime
        except OSError:
            return 0.0


def forget_saved_texts() -> None:
    """Let imports and tracebacks read anew what was saved since; call it on any thread."""
    importlib.invalidate_caches()
    with contextlib.suppress(KeyError):  # Another thread forgets the same file.
        linecache.checkcache()


def _find_file(given: str) -> tuple[Path, str]:
    """Return the resolved path of a file or module, and the name that its module gets.

    For a dotted name, the current folder is added to `sys.path`, and the packages above the module
    are imported.

    Raises:
        NodeFileError: There is no such Python file or module.
    """
    path = Path(given)
    dotted = given.replace(".", "_").isidentifier() and path.suffix != ".py" and not path.exists()
    if dotted and "." in given:
        if "" not in sys.path and str(Path.cwd()) not in sys.path:
            sys.path.insert(0, str(Path.cwd()))
        try:
            spec = importlib.util.find_spec(given)
        except (ImportError, ValueError) as error:
            raise NodeFileError(f"{given}: {error}") from None
        if spec is None or not spec.origin or not Path(spec.origin).is_file():
            raise NodeFileError(f"{given}: no such module, and no such file")
        return Path(spec.origin).resolve(), given
    if not path.is_file():
        raise NodeFileError(f"{given}: no such file")
    if path.suffix != ".py":
        raise NodeFileError(f"{given}: not a Python file")
    resolved = path.resolve()
    letters = "".join(char if char.isalnum() else "_" for char in str(resolved))
    return resolved, f"_node_file_{letters}"
