"""The nodes of the user's own Python files, which `--node FILE` names; saved files are reloaded."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from rclpy.context import Context
from rclpy.node import Node

from archo_tui import regular_files
from archo_tui.errors import ArchoError
from archo_tui.hosting.explain import code_of, explain
from archo_tui.hosting.main_function import ComputedError, MainFunction, NodeCall, SkippedCall
from archo_tui.hosting.source import Source
from archo_tui.hosting.time_limit import Interrupted, TookTooLong, run_limited
from archo_tui.hosting.user_file import OURS, NodeFileError, UserFile, forget_saved_texts
from archo_tui.hosting.watch import Stamps, stamps

T = TypeVar("T")

IMPORT_TIME = 10.0  # Seconds that a file may take to be imported.


class FileNode:
    """A maker of one node of a file: as `main()` makes it, or of a node class without arguments.

    Attributes:
        file: The file.
        threads: The number of threads that spin the node, as `Source.threads` returns it.
        has_executor: True if `main()` names an executor class of rclpy.
    """

    def __init__(self, file: NodeFile, call: NodeCall) -> None:
        """Create a maker.

        Args:
            file: The file.
            call: The call in `main()` that makes the node.
        """
        self.file, self._node_class, self._call = file, call.node_class, call
        self.threads = file.source.threads()
        self.has_executor = file.source.has_executor()

    @property
    def class_name(self) -> str:
        """The name of the node's class, for messages."""
        return self._node_class.__name__

    def __call__(self, context: Context, begun: Callable[[Node], None], **options: Any) -> Node:
        """Make the node in the calling thread.

        If the constructor raises, what it has made so far is taken off the graph.

        Args:
            context: The rclpy context. A constructor that does not take it, as in textbooks, makes
                the node in the default context.
            begun: Called with the node before its constructor runs.
            **options: Further arguments for the constructor, in the place of those of the same name
                in `main()`.

        Raises:
            NodeFileError: The constructor raised, does not run that of Node, or does not take
                `options`; the text names the file, and the line if there is one.
            Interrupted: The constructor was interrupted.
        """
        known = inspect.signature(self._node_class.__init__).parameters
        takes_all = any(p.kind == p.VAR_KEYWORD for p in known.values())
        given = {"context": context, **options}
        if not takes_all:
            if options.keys() - known.keys():
                raise NodeFileError(
                    f"{self.file}: {self._node_class.__name__} takes no {', '.join(options)}, "
                    "so a copy would have the same name"
                )
            given = {name: value for name, value in given.items() if name in known}
        given = self._call.keywords | given
        return self.file.run_explained(lambda: self._construct(given, begun))

    def _construct(self, given: dict[str, Any], begun: Callable[[Node], None]) -> Node:
        node = self._node_class.__new__(self._node_class)
        begun(node)
        try:
            node.__init__(*self._call.args, **given)  # type: ignore[misc]
        except BaseException as error:
            why = None if _is_made(node) else self._constructor_fault(error)
            if why is not None:
                raise why from error
            with contextlib.suppress(Exception):  # The constructor may not have come that far.
                node.destroy_node()  # Otherwise half of it stays on the graph, with its name.
            raise
        if not _is_made(node):
            raise self._missing_super_error()
        return node

    def _constructor_fault(self, error: BaseException) -> NodeFileError | None:
        """Return an error that explains why a constructor failed before rclpy's `__init__` ran.

        Either the class does not call `Node.__init__`, or its own `__init__` needs other arguments.

        Args:
            error: The error of the constructor.

        Returns:
            The error to raise instead; None if the constructor's error explains itself.
        """
        stack = traceback.extract_tb(error.__traceback__)
        own = [self.file.code.is_own(frame.filename) for frame in stack]
        # rclpy lacks an attribute that its __init__ would have made.
        if isinstance(error, AttributeError) and not own[-1]:
            return self._missing_super_error()
        if not isinstance(error, TypeError) or any(own):
            return None
        init = code_of(self._node_class.__init__)
        if init is None or not self.file.code.is_own(init.co_filename):
            return self._missing_super_error()
        if self._call.line:
            where, call = f"{self.file}:{self._call.line}", self._call.text
            return NodeFileError(f"{where}: TypeError: {error}, in: {call}")
        where = f"{self.file.code.display_name(init.co_filename)}:{init.co_firstlineno}"
        hint = f"a node is made without arguments, as {self._node_class.__name__}()"
        return NodeFileError(f"{where}: TypeError: {error}: {hint}")

    def _missing_super_error(self) -> NodeFileError:
        """Return the error for a class that does not call the `__init__` of Node."""
        line, what = self.file.source.missing_super_init(self._node_class.__name__)
        return NodeFileError(f"{self.file}:{line}: {what}")


def _is_made(node: Node) -> bool:
    """Return True if rclpy's own `Node.__init__` has run."""
    try:
        node.get_name()
    except AttributeError:
        return False
    return True


class NodeFile(UserFile):
    """A node file, and the modules that it imports from its folder.

    Attributes:
        path: The path of the file.
        code: The code of the file and of its folder, as messages name it.
        loaded: Time and size of each file when it was last loaded, or could not be loaded.
        source: The syntax tree of the text that `load` parsed last; an empty one before.
        not_run: One line about the calls of its `main()` that are not made here; "" if there are
            none.
    """

    def __init__(self, given: str) -> None:
        """Find the file, without reading it; see `UserFile` for the dotted name of a module.

        Args:
            given: Its path, or the dotted name of a module, as the user typed it.

        Raises:
            NodeFileError: There is no such file or module.
        """
        super().__init__(given)
        self._modules: dict[str, ModuleType] = {}  # The file's own, by their names.
        self._before: dict[str, ModuleType] = {}  # Those of the text before.
        self.not_run = ""
        self._failed = False

    def current_stamps(self) -> Stamps:
        """Return the stamps now of the file and the modules of its folder that it imports.

        After a failed load or `restore`, all Python files of the folder are among them.
        """
        own = {Path(module.__file__) for module in self._modules.values() if module.__file__}
        beside = self.path.parent.glob("*.py") if self._failed else ()
        return stamps({self.path, *own, *beside})

    def load(self) -> list[FileNode]:
        """Import the file and its modules as they are now, within IMPORT_TIME, in a thread.

        `loaded`, `source` and `not_run` are set, and the folder can be imported from. `main()` is
        not run.

        Returns:
            A maker for each node that `main()` makes, or, if it makes none, for each node class
            that the file defines and does not subclass itself.

        Raises:
            NodeFileError: The file cannot be imported in that time, defines no node, or makes one
                with arguments that only running `main()` could tell; the previous modules stay in
                place.
        """
        before = {name: sys.modules.pop(name) for name in self._modules if name in sys.modules}
        known = set(sys.modules)
        self._failed = False
        try:
            nodes = self._run_limited(self._run, IMPORT_TIME, "its import")
        except ArchoError:
            for name in self._imported_modules(known):
                del sys.modules[name]
            sys.modules.update(before)
            self._failed = True
            raise
        else:
            self._before = before
            self._modules = {name: sys.modules[name] for name in self._imported_modules(known)}
        finally:
            self.loaded = self.current_stamps()
        return nodes

    def restore(self) -> None:
        """Put the modules of the previous text back, so that its nodes can be constructed again.

        As after a failed load, a change of any Python file of the folder reloads the file.
        """
        for name in self._modules:
            sys.modules.pop(name, None)
        sys.modules.update(self._before)
        self._modules = self._before
        self._failed = True
        self.loaded = self.current_stamps()

    def _imported_modules(self, known: set[str]) -> list[str]:
        """Return the names of imported modules from the file's folder that are not in `known`."""
        return [
            name
            for name, module in list(sys.modules.items())
            if name not in known
            and not name.startswith(OURS)
            and self.code.is_own(getattr(module, "__file__", None) or "")
        ]

    def _run(self) -> list[FileNode]:
        parent = self._name.rpartition(".")[0]
        folder = str(self.path.parent)  # The files beside it can be imported, as with `python`.
        if parent:
            importlib.import_module(parent)
        elif folder not in sys.path:
            sys.path.insert(0, folder)
        forget_saved_texts()
        module = ModuleType(self._name)
        module.__dict__.update(__file__=str(self.path), __package__=parent)
        sys.modules[self._name] = module
        # No __pycache__ appears in the user's folder.
        writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True
        try:
            text = regular_files.read(self.path)
            code = compile(text, str(self.path), "exec", dont_inherit=True)
            self.source = Source(text)
            early = self.source.spin_at_import()
            if early is not None:
                raise NodeFileError(
                    f"{self}:{early[1]}: {early[0]}() runs when the file is imported: "
                    'put it below if __name__ == "__main__":'
                )
            exec(code, module.__dict__)
        except OSError as error:
            if error.filename != str(self.path):
                raise
            raise NodeFileError(f"{self}: {error.strerror}") from None
        finally:
            sys.dont_write_bytecode = writes
        return self._nodes_by_main(module) or self._node_of_each_class(module)

    def _node_of_each_class(self, module: ModuleType) -> list[FileNode]:
        """Return a maker for each node class that the file defines and does not subclass itself.

        Raises:
            NodeFileError: There is no such class.
        """
        kinds = [
            kind
            for kind in vars(module).values()
            if isinstance(kind, type) and issubclass(kind, Node) and kind.__module__ == self._name
        ]
        nodes = [kind for kind in kinds if not any(kind in other.__mro__[1:] for other in kinds)]
        if not nodes:
            raise NodeFileError(f"{self}: defines no subclass of rclpy.node.Node")
        return [FileNode(self, NodeCall(kind, (), {}, 0, "")) for kind in dict.fromkeys(nodes)]

    def _nodes_by_main(self, module: ModuleType) -> list[FileNode]:
        """Return a maker for each node that `main()` makes, perhaps none; set `not_run`.

        Raises:
            NodeFileError: An argument of a node has a value that only running `main()` could tell.
        """
        try:
            main = MainFunction(self.source.tree, vars(module))
        except ComputedError as error:
            raise NodeFileError(
                f"{self}:{error.line}: {error} takes what main() computes, and main() is not run "
                "here: write the value itself"
            ) from None
        self.not_run = _not_run_text(str(self), main.not_run) if main.made else ""
        return [FileNode(self, call) for call in main.made]

    def _run_limited(self, work: Callable[[], T], seconds: float, what: str) -> T:
        """Run work of the file in a thread, with a time limit, and wait for it.

        Args:
            work: The function to run.
            seconds: The time limit.
            what: The name of the work in the error: `its import`.

        Returns:
            The value that the work returns.

        Raises:
            NodeFileError: The work raised another error than those below, or took too long.
            ArchoError: The work raised this error.
        """
        try:
            return self.run_explained(lambda: run_limited(work, seconds, f"/{self.path.stem}"))
        except TookTooLong as error:
            where, line = self.code.place(error.stack)
            raise NodeFileError(f"{where}: {what} {error}{line}") from None

    def run_explained(self, work: Callable[[], T]) -> T:
        """Run work of the file in the calling thread and return its value.

        Raises:
            NodeFileError: The work raised, SystemExit included; the text says what and where.
            ArchoError: The work raised this error, which explains itself.
            Interrupted: The work was interrupted.
            TookTooLong: The work took longer than its time limit.
        """
        try:
            return work()
        except (ArchoError, Interrupted, TookTooLong):
            raise
        except BaseException as error:
            raise NodeFileError(*explain(error, self.code, self.source)) from None


def _not_run_text(file: str, calls: list[SkippedCall]) -> str:
    """Return one line about the calls of `main()` that are not made here; "" if there are none."""
    if not calls:
        return ""
    line, function, text = calls[0]
    by = f"{function}()" if function else 'what stands below if __name__ == "__main__"'
    lines = sorted({call.line for call in calls} - {line})
    more = f", nor is line {lines[0]}" if len(lines) == 1 else ""
    if len(lines) > 1:
        more = f", nor are lines {', '.join(map(str, lines))}"
    return f"{file}:{line}: {by} calls {text}, which is not run here{more}"
