"""A user's Python file as a program, as `python FILE` runs it."""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import importlib.util
import inspect
import linecache
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any
from weakref import WeakSet

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from archo_tui.base import regular_files
from archo_tui.base.errors import ArchoError
from archo_tui.user_code.errors import (
    NodeFileError,
    OwnCode,
    code_of,
    explain,
    is_made,
    missing_super_error,
)
from archo_tui.user_code.source import Source
from archo_tui.user_code.watch import Stamps, stamps

OURS = ("archo_tui", "archo_bringup", "rclpy")  # Never reloaded, wherever the file is.


class ProgramFile:
    """A Python file as a program, with the modules that it imports from its folder."""

    def __init__(self, given: str, function: str = "") -> None:
        """Find the file, without reading it.

        For a dotted name, the current folder is added to `sys.path`, and the packages above the
        module are imported.
        """
        self._given, self._function = given, function
        self.path, self._name = _find_file(given)
        self.code = OwnCode(given, self.path)
        self.loaded: Stamps = {}  # Of the text that was last compiled, or could not be.
        self.imported: set[Path] = set()  # Of its folder, in this run or before.
        self.does_not_import = False  # The text that was last compiled failed before it began.
        self.source = Source(b"")
        self._compiled = compile("", given, "exec")
        self._has_run = False
        self.class_count = 1  # Of node classes that a file without a main() has made and spun.
        self._began = 0  # Unix time in nanoseconds at which it was last run.

    def __str__(self) -> str:
        return self._given

    @property
    def saved(self) -> float:
        """The Unix time in seconds at which the file was saved; 0.0 while there is no file."""
        try:
            return self.path.stat().st_mtime
        except OSError:
            return 0.0

    def current_stamps(self) -> Stamps:
        """Return the stamps of the file, and of the modules that are imported from its folder.

        If the text `does_not_import`, all Python files of the folder are among them. Modules that
        were imported since the last call, and not saved since, count as unchanged.
        """
        self.note_imports()
        beside = self.path.parent.glob("*.py") if self.does_not_import else ()
        now = stamps({self.path, *self.imported, *beside})
        # What was imported since the start, and was saved before, is as it was loaded.
        news = {path: stamp for path, stamp in now.items() if stamp[0] <= self._began}
        self.loaded = {**news, **self.loaded}
        return now

    def compile(self) -> None:
        """Read and compile the text as it is now, without running it; set `loaded` and `source`."""
        self._began = time.time_ns()
        self.does_not_import, self.class_count = False, 1
        self.loaded = self.current_stamps()
        try:
            text = regular_files.read(self.path)
            self._compiled = compile(text, str(self.path), "exec", dont_inherit=True)
            self.source = Source(text)
        except OSError as error:
            raise NodeFileError(f"{self}: {error.strerror}") from None
        # ValueError: null bytes; the others: a text that is nested too deep.
        except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
            raise NodeFileError(*explain(error, self.code, self.source)) from None

    def run(self, use_as_main: Callable[[ModuleType], None], has_begun: Callable[[], bool]) -> None:
        """Run the compiled text in the calling thread: its `main()`, or else its node classes.

        Modules of the file's folder are imported anew, but for the first run. The folder becomes
        the first in `sys.path`, but for a dotted name.
        """
        module = self._new_module()
        if self._function:
            sys.modules[self._name] = module
        else:
            use_as_main(module)
        writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # In the user's folder.
        try:
            exec(self._compiled, module.__dict__)
        finally:
            sys.dont_write_bytecode = writes
        if self._function:
            function = getattr(module, self._function, None)
            if function is None:
                raise NodeFileError(f"{self}: has no function {self._function}")
            code = function()
            if code is not None:
                raise SystemExit(code)  # As the script that an installation makes.
        elif not (self.source.has_main_block() or has_begun()):
            self._run_main(module)

    def _new_module(self) -> ModuleType:
        if self._has_run:
            for name in self.own_modules():
                sys.modules.pop(name, None)  # Another program of the folder may be faster.
        self._has_run = True
        package = self._name.rpartition(".")[0]
        if package:
            importlib.import_module(package)
        else:
            self._import_from_folder()
        forget_saved_texts()
        module = ModuleType(self._name if self._function else "__main__")
        module.__dict__.update(__file__=str(self.path), __package__=package)
        if self._function:
            module.__spec__ = importlib.util.spec_from_file_location(self._name, self.path)
        return module

    def _run_main(self, module: ModuleType) -> None:
        """Call `main()`; without one, make a node of each node class, and spin each alone."""
        main = vars(module).get("main")
        if callable(main):
            result = main()
            if inspect.iscoroutine(result):
                asyncio.run(result)
            return
        kinds = [
            kind
            for kind in vars(module).values()
            if isinstance(kind, type) and issubclass(kind, Node) and kind.__module__ == "__main__"
        ]
        last = [kind for kind in kinds if not any(kind in other.__mro__[1:] for other in kinds)]
        first, *others = dict.fromkeys(last) or [None]
        if first is None:
            return  # A program without a node.
        self.class_count = 1 + len(others)
        rclpy.init()
        errors: list[BaseException] = []
        threads = [threading.Thread(target=self._spin, args=(kind, errors)) for kind in others]
        for thread in threads:
            thread.start()
        self._spin(first, errors if others else None)
        for thread in threads:
            thread.join()
        if errors:
            raise errors[0]

    def _spin(self, kind: type[Node], errors: list[BaseException] | None) -> None:
        """Spin a node; with others beside it, an error ends them all, and is added to `errors`."""
        try:
            node = self._make(kind)
            rclpy.spin(node, None if errors is None else SingleThreadedExecutor())
        except ExternalShutdownException:
            return
        except Exception as error:
            if errors is None:
                raise
            errors.append(error)
            rclpy.try_shutdown()

    def _make(self, kind: Any) -> Node:
        """Make a node without arguments."""
        node: Node = kind.__new__(kind)
        try:
            node.__init__()  # type: ignore[misc]
        except TypeError as error:
            stack = traceback.extract_tb(error.__traceback__)
            if is_made(node) or any(self.code.is_own(frame.filename) for frame in stack):
                raise
            init = code_of(kind.__init__)
            if init is None or not self.code.is_own(init.co_filename):
                raise missing_super_error(kind.__name__, self.code, self.source) from error
            where = f"{self.code.display_name(init.co_filename)}:{init.co_firstlineno}"
            hint = f"a node is made without arguments, as {kind.__name__}()"
            raise NodeFileError(f"{where}: TypeError: {error}: {hint}") from error
        if not is_made(node):
            raise missing_super_error(kind.__name__, self.code, self.source)
        return node

    def _import_from_folder(self) -> None:
        """Let imports look in the file's folder first, as `python FILE` does.

        A module that a program of another folder has imported is forgotten if one of this folder
        has the same name.
        """
        folder = self.path.parent
        sys.path[:] = [str(folder), *(path for path in sys.path if path != str(folder))]
        for other in _run_files - {self}:
            other.note_imports()
            for name, file in other.own_modules().items():
                beside = folder / name.partition(".")[0]
                is_here = beside.is_dir() or beside.with_suffix(".py").is_file()
                if is_here and not self.code.is_own(str(file)):
                    del sys.modules[name]
        _run_files.add(self)

    def explain(self, error: BaseException) -> tuple[str, str]:
        """Return an error of the program in one line, with its place, and the traceback."""
        if isinstance(error, ArchoError):
            return str(error), ""
        return explain(error, self.code, self.source)

    def print_thread_error(self, error: BaseException | None) -> None:
        """Print the error that ends the present thread, in one line."""
        if error is not None:
            name, (text, _) = threading.current_thread().name, self.explain(error)
            sys.stdout.write(f"exception in thread {name}: {text}\n")

    def note_imports(self) -> None:
        """Add the modules of the file's folder that are imported by now to `imported`."""
        self.imported.update(self.own_modules().values())

    def own_modules(self) -> dict[str, Path]:
        """Return the files of the imported modules of the folder, by name, without `__main__`."""
        return {
            name: Path(file)
            for name, module in list(sys.modules.items())
            if not name.startswith(OURS)
            and name != "__main__"
            and self.code.is_own(file := getattr(module, "__file__", None) or "")
        }

    def without_name(self, text: str) -> str:
        """Shorten `FILE:31: NameError: ...` to `line 31: NameError: ...`, where FILE is known."""
        prefix = f"{self}:"
        if not text.startswith(prefix):
            return text
        rest = text.removeprefix(prefix)
        return f"line {rest}" if rest[:1].isdigit() else rest.strip()


_run_files: WeakSet[ProgramFile] = WeakSet()  # That were run as `__main__` in this process.


def forget_saved_texts() -> None:
    """Let imports and tracebacks read anew what was saved since; call it on any thread."""
    importlib.invalidate_caches()
    with contextlib.suppress(KeyError):  # Another thread forgets the same file.
        linecache.checkcache()


def _find_file(given: str) -> tuple[Path, str]:
    """Return the resolved path of a file or module, and the dotted name of the latter."""
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
        why = "not a regular file" if path.exists() else "no such file"
        raise NodeFileError(f"{given}: {why}")
    if path.suffix != ".py":
        raise NodeFileError(f"{given}: not a Python file")
    return path.resolve(), "__main__"
