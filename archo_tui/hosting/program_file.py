"""A Python file that runs as with `python FILE`: a program of `--run FILE` or of a launch file."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from weakref import WeakSet

from archo_tui import regular_files
from archo_tui.errors import ArchoError
from archo_tui.hosting.explain import explain
from archo_tui.hosting.source import Source
from archo_tui.hosting.user_file import OURS, NodeFileError, UserFile, forget_saved_texts
from archo_tui.hosting.watch import Stamps, stamps


class ProgramFile(UserFile):
    """A Python file as a program, with the modules that it imports from its folder.

    Attributes:
        path: The path of the file.
        code: The code of the file and of its folder, as messages name it.
        loaded: The stamps of the text that was last compiled, or could not be compiled.
        imported: The files of its folder that were seen to be imported, in this run or before.
        source: The syntax tree of the text that was last compiled.
    """

    def __init__(self, given: str, function: str = "") -> None:
        """Find the file, without reading it; see `UserFile` for the dotted name of a module.

        Args:
            given: Its path, or the dotted name of a module, as the user typed it.
            function: The function of the module that is called; "" if the file is run as
                `__main__`.

        Raises:
            NodeFileError: There is no such file or module.
        """
        super().__init__(given)
        self._function = function
        self.imported: set[Path] = set()
        self._compiled = compile("", given, "exec")
        self._has_run = False
        self._began = 0  # Unix time in nanoseconds at which it was last run.

    def current_stamps(self) -> Stamps:
        """Return the stamps of the file, and of the modules that are imported from its folder.

        Modules that were imported since the last call are added to `imported`, and, if they were
        not saved since the file was compiled, to `loaded`: they count as unchanged.
        """
        self.note_imports()
        now = stamps({self.path, *self.imported})
        # What was imported since the start, and was saved before, is as it was loaded.
        news = {path: stamp for path, stamp in now.items() if stamp[0] <= self._began}
        self.loaded = {**news, **self.loaded}
        return now

    def compile(self) -> None:
        """Read and compile the text as it is now, without running it; set `loaded` and `source`.

        Raises:
            NodeFileError: The file cannot be read, or is not Python. `loaded` is set then, too, so
                that only a new text is tried again.
        """
        self._began = time.time_ns()
        self.loaded = self.current_stamps()
        try:
            text = regular_files.read(self.path)
            self._compiled = compile(text, str(self.path), "exec", dont_inherit=True)
            self.source = Source(text)
        except OSError as error:
            raise NodeFileError(f"{self}: {error.strerror}") from None
        except (SyntaxError, ValueError) as error:  # ValueError: null bytes.
            raise NodeFileError(*explain(error, self.code, self.source)) from None

    def run(self, use_as_main: Callable[[ModuleType], None]) -> None:
        """Run the compiled text in the calling thread, and then the function, if one was given.

        Modules of the file's folder are imported anew, but for the first run. The folder becomes
        the first in `sys.path`, but for a dotted name.

        Args:
            use_as_main: Makes a module the `__main__` that this program sees; not called if a
                function was given.

        Raises:
            NodeFileError: The module does not have the function.
            SystemExit: The function returned something else than None, which is the exit code.
            BaseException: The exception that the program raises.
        """
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
            sys.modules[self._name] = module
        else:
            use_as_main(module)
        exec(self._compiled, module.__dict__)
        if self._function:
            function = getattr(module, self._function, None)
            if function is None:
                raise NodeFileError(f"{self}: has no function {self._function}")
            code = function()
            if code is not None:
                raise SystemExit(code)  # As the script that an installation makes.

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
        """Return an error of the program in one line, with its place, and the traceback.

        For an ArchoError these are its text and "".
        """
        if isinstance(error, ArchoError):
            return str(error), ""
        return explain(error, self.code, self.source)

    def note_imports(self) -> None:
        """Add the modules of the file's folder that are imported by now to `imported`."""
        self.imported.update(self.own_modules().values())

    def own_modules(self) -> dict[str, Path]:
        """Return the files of the imported modules of the folder, by name, without `__main__`.

        Modules of the console and of rclpy are left out, even if they are in that folder.
        """
        return {
            name: Path(file)
            for name, module in list(sys.modules.items())
            if not name.startswith(OURS)
            and name != "__main__"
            and self.code.is_own(file := getattr(module, "__file__", None) or "")
        }


_run_files: WeakSet[ProgramFile] = WeakSet()  # That were run as `__main__` in this process.
