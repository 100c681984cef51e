"""A package of a workspace: what its package.xml says, and what it installs."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from archo_tui import regular_files
from archo_tui.errors import ArchoError
from archo_tui.ros_names import KINDS

if TYPE_CHECKING:
    from archo_tui.launch.setup_script import PackageSetup

INDEX = Path("share", "ament_index", "resource_index", "packages")  # Below a prefix.
_WITHOUT_EXPORT = "catkin"  # What REP 149 takes where package.xml has no build_type.
# `install(DIRECTORY launch config DESTINATION share/${PROJECT_NAME})`, and others plainly written.
_INSTALL = re.compile(
    r"install\s*\(\s*(DIRECTORY|FILES|PROGRAMS)\s+([^()]*?)\s+DESTINATION\s+([^\s()]+)"
    r"(?:\s+RENAME\s+([^\s()]+))?"
)


@dataclass(frozen=True)
class EntryPoint:
    """A function or a script that runs a node, as an executable of a package names it."""

    module: str  # Dotted; the path of a script.
    function: str  # "" for a script, which runs as `python FILE` runs it.
    source: str  # The folder to import it from; "" for an installed package.

    def make_importable(self) -> None:
        """Put the source folder first in `sys.path`, so that this process can import the module."""
        if self.source and self.source not in sys.path:
            sys.path.insert(0, self.source)


@dataclass(frozen=True)
class Package:
    """A package in its source folder; what its setup.py says is asked for once, and blocks."""

    name: str
    folder: Path  # Of its package.xml.
    build_type: str  # `ament_python`, `ament_cmake`, ...; `catkin` if package.xml names none.

    @property
    def has_interfaces(self) -> bool:
        """True if the package has a folder msg/, srv/ or action/."""
        return any((self.folder / kind).is_dir() for kind in KINDS)

    @property
    def is_python(self) -> bool:
        return self.build_type == "ament_python"

    @property
    def build_file(self) -> Path:
        """The file that says what the package installs."""
        return self.folder / ("setup.py" if self.is_python else "CMakeLists.txt")

    @cached_property
    def _setup(self) -> PackageSetup:
        from archo_tui.launch import setup_script  # Late: a start with --interfaces needs none.

        return setup_script.run_setup(self.build_file)

    def executables(self) -> dict[str, EntryPoint]:
        """Return the executables in Python, by their names for `ros2 run`; raise ArchoError."""
        if self.is_python:
            source = str((self.folder / self._setup.source).resolve())
            scripts = self._setup.console_scripts
            return {
                name: EntryPoint(target[0], target[1], source) for name, target in scripts.items()
            }
        folder = self.folder.resolve()
        return {
            target.name: EntryPoint(str(folder / source), "", str(folder))
            for source, target in self._installed_files("PROGRAMS")
            if target.parent == Path("lib", self.name)
        }

    def share_folder(self, prefix: Path) -> Path:
        """Return the share folder below a prefix, which has files after `fill_share_folder`."""
        return prefix / "share" / self.name

    def fill_share_folder(self, prefix: Path) -> None:
        """Fill the share folder with links into the sources, unless it is filled.

        It has what setup.py or CMakeLists.txt installs, so what is missing there is missing here.
        Raises ArchoError.
        """
        marker = prefix / INDEX / self.name
        if not marker.exists():
            # colcon installs these two, whatever setup.py says.
            for source, target in [
                *self._installed_files("FILES", "DIRECTORY"),
                (Path("package.xml"), self.share_folder(Path()) / "package.xml"),
            ]:
                _link(self.folder / source, prefix / target)
            marker.parent.mkdir(parents=True, exist_ok=True)
            marker.touch()

    def _installed_files(self, *kinds: str) -> Iterator[tuple[Path, Path]]:
        """Yield each installed file: its path in the package's folder, and that below a prefix."""
        if self.is_python:
            for folder, names in self._setup.data_files:
                for name in names:
                    # setuptools refuses such a file, too, when the package is built.
                    if not (self.folder / name).is_file():
                        raise ArchoError(f"{self.build_file}: data_files: {name} is no file")
                    yield Path(name), Path(folder, Path(name).name)
            return
        for kind, names, destination, rename in _INSTALL.findall(self._cmake_text()):
            for name in names.split() if kind in kinds else ():
                source, target = Path(name), Path(destination)
                if kind != "DIRECTORY":
                    yield source, target / (rename or source.name)
                    continue
                # `DIRECTORY launch` installs the folder, `DIRECTORY launch/` what is in it.
                base = source if name.endswith("/") else source.parent
                for path in sorted((self.folder / source).rglob("*")):
                    if path.is_file():
                        inside = path.relative_to(self.folder)
                        yield inside, target / inside.relative_to(base)

    def _cmake_text(self) -> str:
        try:
            text = self.build_file.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""
        return re.sub(r'#.*|"', "", text).replace("${PROJECT_NAME}", self.name)


def read_package(folder: Path) -> Package:
    """Return the package of a folder; raise ArchoError with file and line."""
    file = folder / "package.xml"
    try:
        root = ElementTree.fromstring(regular_files.read(file))
    except OSError as error:
        raise ArchoError(f"{file}: {error.strerror}") from None
    except ElementTree.ParseError as error:
        raise ArchoError(f"{file}:{error.position[0]}: not XML: {error}") from None
    except (LookupError, ValueError):  # As for `encoding="none such"`.
        raise ArchoError(f"{file}:1: not XML: its encoding is not known") from None
    name = (root.findtext("name") or "").strip()
    if not name:
        raise ArchoError(f"{file}:1: no <name>: it names the package, <name>my_package</name>")
    build_type = (root.findtext("export/build_type") or _WITHOUT_EXPORT).strip()
    return Package(name, folder, build_type)


def _link(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        if not target.exists():
            os.symlink(source.resolve(), target)
    except OSError:  # Windows allows links to few users.
        shutil.copyfile(source, target)
