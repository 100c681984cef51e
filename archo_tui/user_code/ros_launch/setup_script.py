"""The executables and files of an ament_python package, learned by running its setup.py.

It runs in a process, in which `setup()` is called and nothing is built. `setuptools` is a stand-in,
because Python has had none of its own since 3.12.
"""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from archo_tui.base.errors import ArchoError
from archo_tui.user_code.ros_launch import child_process

SETUP_TIME = 5.0  # Seconds that a setup.py may take.
_COMMANDS = ["build", "build_ext", "build_py", "develop", "egg_info", "install", "sdist", "test"]
_MODULES = (
    *("setuptools", "setuptools.command", "distutils", "distutils.core"),
    *(f"setuptools.command.{name}" for name in _COMMANDS),
)


class PackageSetup(NamedTuple):
    """The arguments of a package's `setup()` that say what can be run and found."""

    console_scripts: Mapping[str, Sequence[str]]  # Module and function, by the executable.
    # Folders below the prefix, and their files.
    data_files: list[tuple[str, list[str]]]
    source: str  # The folder of the package's modules, in that of the setup.py.


def run_setup(file: Path) -> PackageSetup:
    """Run a setup.py in a process of its own, which installs nothing; blocks some seconds."""
    if not file.is_file():
        raise ArchoError(f"{file}: an ament_python package needs it: ros2 pkg create writes one")
    try:
        value, _ = child_process.ask(__name__, str(file.resolve()), SETUP_TIME)
    except child_process.ChildError as error:
        where = f"{error.file}:{error.line}" if error.file else file
        raise ArchoError(f"{where}: {error}") from None
    return PackageSetup(**value)


def main() -> None:
    """Answer the request of `run_setup`, and end the process."""
    child_process.serve(run, lambda filename: Path.cwd() in Path(filename).parents)


def run(file: str) -> dict[str, Any]:
    """Run a setup.py in its folder, and return what its last `setup()` says; raise ChildError."""
    calls: list[dict[str, Any]] = []
    os.chdir(Path(file).parent)
    sys.argv = [file, "install"]
    sys.path.insert(0, str(Path(file).parent))
    for name in _MODULES:
        module = sys.modules[name] = _StandIn(name)
        module.__dict__.update(
            setup=lambda **arguments: calls.append(arguments),
            find_packages=lambda *_, **__: [],
            find_namespace_packages=lambda *_, **__: [],
        )
        parent, _, last = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], last, module)
    runpy.run_path(file, run_name="__main__")
    if not calls:
        raise child_process.ChildError("it does not call setup()", file, 1)
    given = calls[-1]
    entry_points = given.get("entry_points") or {}
    try:
        return {
            "console_scripts": dict(map(_script, entry_points.get("console_scripts") or ())),
            "data_files": [
                (str(folder), [*map(str, names)]) for folder, names in given.get("data_files") or ()
            ],
            "source": str((given.get("package_dir") or {}).get("", ".")),
        }
    except (TypeError, ValueError, AttributeError) as error:
        raise child_process.ChildError(f"setup() is called wrongly: {error}", file, 1) from error


class _StandIn(ModuleType):
    """A module of which each name is a class, such as a command that a setup.py derives from.

    A class takes any arguments.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__path__: list[str] = []

    def __getattr__(self, name: str) -> type:
        if name.startswith("__"):
            raise AttributeError(name)
        return type(name, (), {"__init__": lambda *_, **__: None, "user_options": []})


def _script(line: str) -> tuple[str, tuple[str, str]]:
    """Return a line of `console_scripts` as its name, its module and its function."""
    name, is_one, target = line.partition("=")
    module, is_function, function = target.partition("[")[0].partition(":")
    if not is_one or not is_function:
        raise ValueError(f"{line!r}: write 'name = package.module:function'")
    return name.strip(), (module.strip(), function.strip())
