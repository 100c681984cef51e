"""How a node of a file of the user's own is made."""

from __future__ import annotations

import contextlib
import inspect
import traceback
from types import CodeType
from typing import TYPE_CHECKING, Any

from rclpy.context import Context
from rclpy.node import Node

from archo_tui.errors import ArchoError

if TYPE_CHECKING:
    from archo_tui.hosting.node_files import NodeFile

CONSTRUCTION_TIME = 2.0  # s that a node's constructor may take


class NodeFileError(ArchoError):
    """One line that says what is wrong with a file, and the traceback for whoever wrote it."""

    def __init__(self, said: str, report: str = "") -> None:
        super().__init__(said)
        self.report = report


class FileNode:
    """Makes one node of a class that a file defines, as `main()` of the file would."""

    def __init__(self, file: NodeFile, kind: type[Node], threads: int | None) -> None:
        """`threads` as `Source.threads` has it."""
        self.file, self._kind, self.threads = file, kind, threads

    def __call__(self, context: Context, **options: Any) -> Node:
        """Raises NodeFileError that names file and line for whatever the constructor raises.

        A textbook's constructor takes nothing: its node is made in the default context.
        """
        known = inspect.signature(self._kind).parameters
        takes_all = any(p.kind == p.VAR_KEYWORD for p in known.values())
        given = {"context": context, **options}
        if not takes_all:
            if options.keys() - known.keys():
                raise NodeFileError(
                    f"{self.file}: {self._kind.__name__} takes no {', '.join(options)}, "
                    "so a copy would have the same name"
                )
            given = {name: value for name, value in given.items() if name in known}
        name = f"{self._kind.__name__}.__init__"
        return self.file.limited(lambda: self._made(given), CONSTRUCTION_TIME, name)

    def _made(self, given: dict[str, Any]) -> Node:
        node = self._kind.__new__(self._kind)
        try:
            node.__init__(**given)  # type: ignore[misc]
        except BaseException as error:
            why = None if _is_made(node) else self._why_unmade(error)
            if why is not None:
                raise why from error
            with contextlib.suppress(Exception):  # it may not be that far
                node.destroy_node()  # else half of it stays on the graph, by its name
            raise
        if not _is_made(node):
            raise self._unmade()
        return node

    def _why_unmade(self, error: BaseException) -> NodeFileError | None:
        """What was done wrong when rclpy's `__init__` did not run; None: see the error itself."""
        stack = traceback.extract_tb(error.__traceback__)
        own = [self.file.is_own(frame.filename) for frame in stack]
        if isinstance(error, AttributeError) and not own[-1]:  # rclpy lacks what it would have made
            return self._unmade()
        if not isinstance(error, TypeError) or any(own):
            return None
        init = code_of(self._kind.__init__)
        if init is None or not self.file.is_own(init.co_filename):
            return self._unmade()
        where = f"{self.file.named(init.co_filename)}:{init.co_firstlineno}"
        said = f"a node is made without arguments, as {self._kind.__name__}()"
        return NodeFileError(f"{where}: TypeError: {error}: {said}")

    def _unmade(self) -> NodeFileError:
        line, said = self.file.source.unmade(self._kind.__name__)
        return NodeFileError(f"{self.file}:{line}: {said}")


def _is_made(node: Node) -> bool:
    """False when rclpy's own `__init__` did not run."""
    try:
        node.get_name()
    except AttributeError:
        return False
    return True


def code_of(value: Any) -> CodeType | None:
    """Of a callback, or of a timer or service that has one."""
    with contextlib.suppress(Exception):  # whatever a stranger's property raises
        callback = getattr(value, "callback", value)
        code = getattr(getattr(callback, "__func__", callback), "__code__", None)
        return code if isinstance(code, CodeType) else None
    return None
