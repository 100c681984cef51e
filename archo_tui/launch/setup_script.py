"""The executables and files of an ament_python package, learned by running its setup.py.

It runs in a process, in which `setup()` is called and nothing is built. `setuptools` is a stand-in,
because Python has had none of its own since 3.12.
"""

from __future__ import annotations

import configparser
import fnmatch
import os
import runpy
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.launch import child_process, user_errors
from archo_tui.launch.package import Package

SETUP_TIME = 5.0  # Seconds that a setup.py may take.
_COMMANDS = ("build", "build_ext", "build_py", "develop", "egg_info", "install", "sdist", "test")


@dataclass(frozen=True)
class PackageSetup:
    """The arguments of a package's `setup()` that say what can be run and found."""

    console_scripts: dict[str, str]  # `module:function`, by the executable.
    # Folders below the prefix, and their files.
    data_files: tuple[tuple[str, tuple[str, ...]], ...]
    source: Path  # The folder that the package's modules are imported from.


def run_setup(package: Package) -> PackageSetup:
    """Run a setup.py in a process of its own, which installs nothing; blocks some seconds."""
    file = package.folder / "setup.py"
    if not file.is_file():
        raise ArchoError(f"{file}: an ament_python package needs it: ros2 pkg create writes one")
    reply = child_process.ask(__name__, str(file.resolve()), SETUP_TIME)
    value: Any = reply.value
    if value is None:
        raise ArchoError(f"{file}: it ended Python, exit code {reply.exit_code}")
    if "error" in value:
        path, line, text, _ = value["error"]
        raise ArchoError(f"{path}:{line}: {text}" if path else f"{file}: {text}")
    return PackageSetup(
        value["console_scripts"],
        tuple((folder, tuple(files)) for folder, files in value["data_files"]),
        (package.folder / value["source"]).resolve(),
    )


def main() -> None:
    """Answer the request of `run_setup`, and end the process."""
    child_process.serve(
        run, lambda frame, seconds: {"error": user_errors.describe_hang(frame, seconds, _is_own)}
    )


def _is_own(filename: str) -> bool:
    return Path.cwd() in Path(filename).parents


def run(file: str) -> dict[str, Any]:
    """Run a setup.py in its folder, and return the arguments of its last `setup()`, or `error`."""
    calls: list[dict[str, Any]] = []
    os.chdir(Path(file).parent)
    sys.argv = [file, "install"]
    sys.path.insert(0, str(Path(file).parent))
    _install_stand_ins(calls)
    try:
        runpy.run_path(file, run_name="__main__")
    except BaseException as error:
        return {"error": user_errors.describe(error, _is_own)}
    if not calls:
        return {"error": (file, 1, "it does not call setup()", "")}
    given = calls[-1]
    try:
        return {
            "console_scripts": _console_scripts(given.get("entry_points") or {}),
            "data_files": [
                (str(folder), [str(name) for name in names])
                for folder, names in given.get("data_files") or ()
            ],
            "source": str((given.get("package_dir") or {}).get("", ".")),
        }
    except (TypeError, ValueError, AttributeError, configparser.Error) as error:
        return {"error": (file, 1, f"setup() is called wrongly: {error}", "")}


def _console_scripts(entry_points: Any) -> dict[str, str]:
    if isinstance(entry_points, str):
        parser = configparser.ConfigParser(delimiters=("=",))
        parser.read_string(entry_points)
        entry_points = {s: [f"{k}={v}" for k, v in parser[s].items()] for s in parser.sections()}
    lines: str | Iterable[str] = entry_points.get("console_scripts") or ()
    if isinstance(lines, str):
        lines = lines.splitlines()
    found = {}
    for line in filter(str.strip, lines):
        name, is_one, target = line.partition("=")
        if not is_one or ":" not in target:
            raise ValueError(f"{line!r}: write 'name = package.module:function'")
        found[name.strip()] = target.partition("[")[0].strip()
    return found


def _install_stand_ins(calls: list[dict[str, Any]]) -> None:
    """Replace setuptools and distutils by modules whose `setup()` appends to `calls`."""

    def setup(**arguments: Any) -> None:
        calls.append(arguments)

    # A class for each command that a setup.py derives its own from.
    commands = {
        f"setuptools.command.{name}": {name: type(name, (), {"user_options": []})}
        for name in _COMMANDS
    }
    modules: Mapping[str, Mapping[str, Any]] = {
        "setuptools": {
            "setup": setup,
            "find_packages": find_packages,
            "find_namespace_packages": find_packages,
            "Command": type("Command", (), {}),
            "Extension": type("Extension", (), {"__init__": lambda *_, **__: None}),
        },
        "setuptools.command": {},
        **commands,
        "distutils": {},
        "distutils.core": {"setup": setup},
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        module.__dict__.update(contents, __path__=[])
        sys.modules[name] = module
        parent, _, last = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], last, module)


def find_packages(
    where: str = ".", exclude: Iterable[str] = (), include: Iterable[str] = ("*",)
) -> list[str]:
    """Return the sorted names of the packages in a folder, as `setuptools.find_packages` does."""
    exclude, include = list(exclude), list(include)
    found = []
    for file in sorted(Path(where).glob("**/__init__.py")):
        name = ".".join(file.parent.relative_to(where).parts)
        folders = [*file.relative_to(where).parents][:-1]
        is_whole = all(Path(where, folder, "__init__.py").is_file() for folder in folders)
        if name and is_whole and _matches(name, include) and not _matches(name, exclude):
            found.append(name)
    return found


def _matches(name: str, patterns: Iterable[str]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)
