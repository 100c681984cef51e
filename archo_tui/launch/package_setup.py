"""The executables and files of an ament_python package, learned by running its setup.py."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.launch import child_process
from archo_tui.launch.package import Package

SETUP_TIME = 5.0  # Seconds that a setup.py may take.
_CHILD = "archo_tui.launch.setup_child"


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
    reply = child_process.ask(_CHILD, str(file.resolve()), SETUP_TIME)
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
