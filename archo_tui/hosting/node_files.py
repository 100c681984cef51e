"""Nodes from Python files of the user's own: `--node FILE`. Read again whenever they are saved."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import inspect
import linecache
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from traceback import StackSummary
from types import CodeType, ModuleType
from typing import Any, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.node import Node

import archo_tui
from archo_tui import regular_files
from archo_tui.errors import ArchoError
from archo_tui.hosting.limited import Interrupted, TookTooLong, run_limited
from archo_tui.hosting.main_function import ComputedError, Made, MainFunction, NotRun
from archo_tui.hosting.source import Source
from archo_tui.hosting.tracebacks import own_frames
from archo_tui.hosting.watch import Stamps, stamps

T = TypeVar("T")

IMPORT_TIME = 10.0  # s that a file may take to be imported
# what rclpy raises without a word
WORDLESS = {"TypeError": "TypeError: a message of another type is expected here"}
# what rcl says of a second type of a topic, which Fast DDS refuses within a process; the second
# one is of a subscription, whose own reason rcl overwrites
_TWO_TYPES = ("with incompatible type", "Failed to create subscription: invalid allocator")
_ONE_TYPE = "another node of this process has the topic with another type, and Fast DDS allows one"
_OF_INTERFACES = ("_msgs", "_srvs", "_interfaces")  # how packages of messages are named
_NOT_CALLED = "give the callback itself: self.name, not self.name()"
_OURS = ("archo_tui", "archo_bringup", "rclpy")  # never read again, wherever the file is


def reason_of(error: BaseException) -> str:
    """Return the first line of an error's text; of one of rcl's with no reason what it means."""
    text = (str(error).splitlines() or [""])[0]
    if any(two in text for two in _TWO_TYPES):
        return f"{text.partition(':')[0]}: {_ONE_TYPE}"
    return text


class NodeFileError(ArchoError):
    """One line that says what is wrong with a file, and the traceback for whoever wrote it."""

    def __init__(self, said: str, report: str = "") -> None:
        super().__init__(said)
        self.report = report


class FileNode:
    """Makes one node of a class that a file defines, as `main()` of the file would."""

    def __init__(self, file: NodeFile, made: Made) -> None:
        self.file, self._kind, self._by_main = file, made.kind, made
        self.threads = file.source.threads()
        self.has_executor = file.source.has_executor()

    @property
    def class_name(self) -> str:
        """The name of the node's class, for messages."""
        return self._kind.__name__

    def __call__(self, context: Context, begun: Callable[[Node], None], **options: Any) -> Node:
        """Raises NodeFileError that names file and line for whatever the constructor raises.

        A textbook's constructor takes no context: its node is made in the default one.

        Args:
            context: The rclpy context, for a constructor that takes it.
            begun: Called with the node before its constructor runs.
            options: Further arguments, for a constructor that takes them.
        """
        known = inspect.signature(self._kind.__init__).parameters
        takes_all = any(p.kind == p.VAR_KEYWORD for p in known.values())
        given = {"context": context, **options}
        if not takes_all:
            if options.keys() - known.keys():
                raise NodeFileError(
                    f"{self.file}: {self._kind.__name__} takes no {', '.join(options)}, "
                    "so a copy would have the same name"
                )
            given = {name: value for name, value in given.items() if name in known}
        given = self._by_main.keywords | given
        return self.file.explained(lambda: self._made(given, begun))

    def _made(self, given: dict[str, Any], begun: Callable[[Node], None]) -> Node:
        node = self._kind.__new__(self._kind)
        begun(node)
        try:
            node.__init__(*self._by_main.args, **given)  # type: ignore[misc]
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
        if self._by_main.line:
            where, said = f"{self.file}:{self._by_main.line}", self._by_main.text
            return NodeFileError(f"{where}: TypeError: {error}, in: {said}")
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


class NodeFile:
    """A file, or a module by its dotted name, and the modules that it imports from its folder."""

    def __init__(self, given: str) -> None:
        """Raises NodeFileError when there is no such file or module."""
        self._given = given
        self.path, self._name = _found(given)
        self._modules: dict[str, ModuleType] = {}  # its own, by their names
        self._before: dict[str, ModuleType] = {}  # those of the text before
        self.loaded: Stamps = {}  # of the text that was last loaded, or tried
        self.source = Source(b"")  # of the text that was last loaded
        self.not_run = ""  # one line about what main() of that text would do besides
        self._failed = False

    def __str__(self) -> str:
        return self._given

    @property
    def saved(self) -> float:
        """Unix time; 0 while there is no file."""
        try:
            return self.path.stat().st_mtime
        except OSError:
            return 0.0

    def look(self) -> Stamps:
        """All that counts as the file; after a failure its whole folder."""
        own = {Path(module.__file__) for module in self._modules.values() if module.__file__}
        beside = self.path.parent.glob("*.py") if self._failed else ()
        return stamps({self.path, *own, *beside})

    def load(self) -> list[FileNode]:
        """The nodes that it defines now. Raises NodeFileError: then all is as it was before."""
        before = {name: sys.modules.pop(name) for name in self._modules if name in sys.modules}
        known = set(sys.modules)
        self._failed = False
        try:
            nodes = self.limited(self._run, IMPORT_TIME, "its import")
        except ArchoError:
            for name in self._own(known):
                del sys.modules[name]
            sys.modules.update(before)
            self._failed = True
            raise
        else:
            self._before = before
            self._modules = {name: sys.modules[name] for name in self._own(known)}
        finally:
            self.loaded = self.look()
        return nodes

    def back(self) -> None:
        """The text before is in force again: the new one's nodes cannot be constructed."""
        for name in self._modules:
            sys.modules.pop(name, None)
        sys.modules.update(self._before)
        self._modules = self._before
        self._failed = True
        self.loaded = self.look()

    def _own(self, known: set[str]) -> list[str]:
        """The modules that are new and lie in its folder."""
        return [
            name
            for name, module in list(sys.modules.items())
            if name not in known
            and not name.startswith(_OURS)
            and self.is_own(getattr(module, "__file__", None) or "")
        ]

    def _run(self) -> list[FileNode]:
        parent = self._name.rpartition(".")[0]
        folder = str(self.path.parent)  # what stands beside it can be imported, as by `python`
        if parent:
            importlib.import_module(parent)
        elif folder not in sys.path:
            sys.path.insert(0, folder)
        importlib.invalidate_caches()
        linecache.checkcache()
        module = ModuleType(self._name)
        module.__dict__.update(__file__=str(self.path), __package__=parent)
        sys.modules[self._name] = module
        writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # nothing in its folder
        try:
            text = regular_files.read(self.path)
            code = compile(text, str(self.path), "exec", dont_inherit=True)
            self.source = Source(text)
            early = self.source.runs_at_import()
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
        return self._by_main(module) or self._all_of(module)

    def _all_of(self, module: ModuleType) -> list[FileNode]:
        """Return a node of each class that no other class is made from."""
        kinds = [
            kind
            for kind in vars(module).values()
            if isinstance(kind, type) and issubclass(kind, Node) and kind.__module__ == self._name
        ]
        nodes = [kind for kind in kinds if not any(kind in other.__mro__[1:] for other in kinds)]
        if not nodes:
            raise NodeFileError(f"{self}: defines no subclass of rclpy.node.Node")
        return [FileNode(self, Made(kind, (), {}, 0, "")) for kind in dict.fromkeys(nodes)]

    def _by_main(self, module: ModuleType) -> list[FileNode]:
        """Return what `main()` makes, and say what else it does, which is not run."""
        try:
            main = MainFunction(self.source.tree, vars(module))
        except ComputedError as error:
            raise NodeFileError(
                f"{self}:{error.line}: {error} takes what main() computes, and main() is not run "
                "here: write the value itself"
            ) from None
        self.not_run = _not_run(str(self), main.not_run) if main.made else ""
        return [FileNode(self, made) for made in main.made]

    def limited(self, work: Callable[[], T], seconds: float, what: str) -> T:
        """The value of `work()`. Raises NodeFileError for what it raises, and when it hangs."""
        try:
            return self.explained(lambda: run_limited(work, seconds, f"/{self.path.stem}"))
        except TookTooLong as error:
            where, line = self.place(error.stack)
            raise NodeFileError(f"{where}: {what} {error}{line}") from None

    def explained(self, work: Callable[[], T]) -> T:
        """The value of `work()`. Raises NodeFileError for what it raises."""
        try:
            return work()
        except (ArchoError, Interrupted, TookTooLong):
            raise
        except BaseException as error:  # SystemExit, too
            raise NodeFileError(*self.said(error)) from None

    def said(self, error: BaseException) -> tuple[str, str]:
        """`FILE:LINE: TypeError: ..., in: x = y + 1`, and the traceback without the engine.

        The line is the last one of the file itself, or of its own modules, that was running.
        """
        name, why = type(error).__name__, reason_of(error)
        report = own_frames(error, rclpy, archo_tui)
        if isinstance(error, SyntaxError) and self.is_own(error.filename or ""):
            place = f"{self.named(error.filename or '')}:{error.lineno}"
            return f"{place}: {name}: {error.msg}{_quoted(error.text or '')}", report
        if isinstance(error, ModuleNotFoundError):
            why += f" (looked for it in {self.path.parent} and where Python looks)"
            if (error.name or "").partition(".")[0].endswith(_OF_INTERFACES):
                why += ": --interfaces DIR takes the package with its .msg files"
        if "must only be called once" in why:
            why = "rclpy.init() runs here already: call it in main() only"
        stack = traceback.extract_tb(error.__traceback__)
        where, line = self.place(stack)
        if line:
            why = self._plainly(where, why)
        else:
            where, why = self._place_of_callback(error, where, why)
        said = f"{name}: {why}".rstrip(": ")
        return f"{where}: {WORDLESS.get(said, said)}{line}", report

    def place(self, stack: StackSummary) -> tuple[str, str]:
        """`FILE:LINE` of the last frame that is its own, and that line, as `, in: x = y + 1`."""
        frames = [frame for frame in stack if self.is_own(frame.filename)]
        if not frames:
            return str(self), ""
        last = frames[-1]
        return f"{self.named(last.filename)}:{last.lineno}", _quoted(last.line or "")

    def _plainly(self, where: str, why: str) -> str:
        """What rclpy says of how it was called, in the words of who called it."""
        early = self.source.called_too_early()
        if "callback" in why and where == f"{self}:{early}":
            return _NOT_CALLED
        if "_TYPE_SUPPORT" in why or "resolve_name(): incompatible" in why:
            return "the type comes first, then the name, as in Float32, 'battery_level'"
        if "__init__() takes 1 positional argument but" in why:
            return f"{why}: name the fields, as in Float32(data=87.5)"
        return why

    def _place_of_callback(self, error: BaseException, where: str, why: str) -> tuple[str, str]:
        """Of what rclpy says of a callback that it calls, or has called."""
        # rclpy's timer stumbles over a variable of its own then
        if isinstance(error, UnboundLocalError) or "'NoneType' object is not callable" in why:
            line = self.source.called_too_early()
            if line is not None:
                return f"{self}:{line}", _NOT_CALLED
        for frame, _ in reversed([*traceback.walk_tb(error.__traceback__)]):
            for value in frame.f_locals.values():
                code = code_of(value)
                if code is not None and self.is_own(code.co_filename):
                    named, line = self.named(code.co_filename), code.co_firstlineno
                    lacks = named == str(self) and self.source.gives_nothing(line)
                    if lacks:
                        why = f"{code.co_name} returns nothing: end it with return {lacks}"
                    elif isinstance(error, TypeError) and code.co_varnames[:1] != ("self",):
                        why += ": its first parameter must be self" if _is_method(value) else ""
                    return f"{named}:{line}", why
        return where, why

    def is_own(self, filename: str) -> bool:
        """True for the file itself and what stands beside it."""
        if not filename:  # what is built in has none
            return False
        path = Path(filename).resolve()
        beside = self.path.parent in path.parents and "site-packages" not in path.parts
        return path == self.path or beside

    def named(self, filename: str) -> str:
        """As the user called it, or what stands beside it by its name."""
        path = Path(filename).resolve()
        return str(self) if path == self.path else path.name


def code_of(value: Any) -> CodeType | None:
    """Of a callback, or of a timer or service that has one."""
    with contextlib.suppress(Exception):  # whatever a stranger's property raises
        callback = getattr(value, "callback", value)
        code = getattr(getattr(callback, "__func__", callback), "__code__", None)
        return code if isinstance(code, CodeType) else None
    return None


def _is_method(value: Any) -> bool:
    return hasattr(getattr(value, "callback", value), "__self__")


def _not_run(file: str, calls: list[NotRun]) -> str:
    """Return one line about calls in `main()` that nobody makes here; "" when there are none."""
    if not calls:
        return ""
    line, function, text = calls[0]
    by = f"{function}()" if function else 'what stands below if __name__ == "__main__"'
    lines = sorted({call.line for call in calls} - {line})
    more = f", nor is line {lines[0]}" if len(lines) == 1 else ""
    if len(lines) > 1:
        more = f", nor are lines {', '.join(map(str, lines))}"
    return f"{file}:{line}: {by} calls {text}, which is not run here{more}"


def _quoted(line: str) -> str:
    return f", in: {line.strip()}" if line.strip() else ""


def _found(given: str) -> tuple[Path, str]:
    """The path of a file or module, and the name that its module gets."""
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
