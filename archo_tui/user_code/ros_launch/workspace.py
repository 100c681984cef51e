"""The packages of a workspace, found as colcon finds them, and what each installs and runs."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from archo_tui.base import regular_files
from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.ros.names import KINDS

if TYPE_CHECKING:
    from archo_tui.user_code.ros_launch.setup_script import PackageSetup

INDEX = Path("share", "ament_index", "resource_index", "packages")  # Below a prefix.
_WITHOUT_EXPORT = "catkin"  # What REP 149 takes where package.xml has no build_type.
# `install(DIRECTORY launch config DESTINATION share/${PROJECT_NAME})`, and others plainly written.
_INSTALL = re.compile(
    r"install\s*\(\s*(DIRECTORY|FILES|PROGRAMS)\s+([^()]*?)\s+DESTINATION\s+([^\s()]+)"
    r"(?:\s+RENAME\s+([^\s()]+))?"
)
_IGNORED = {"COLCON_IGNORE", "AMENT_IGNORE"}  # A folder with such a file is left out.
_BUILT = ("build", "install", "log")  # What colcon makes beside src/.
_MAX_FOLDERS = 20_000  # A home folder is no workspace.
_ALIKE = 0.8  # Above difflib's 0.6, as packages of one project have names that are alike.
_OWN_PACKAGE = "archo_bringup"
_CHECKOUT = Path(__file__).parent.parent.parent.parent


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
    def is_python(self) -> bool:
        return self.build_type == "ament_python"

    @property
    def build_file(self) -> Path:
        """The file that says what the package installs."""
        return self.folder / ("setup.py" if self.is_python else "CMakeLists.txt")

    @cached_property
    def _setup(self) -> PackageSetup:
        from archo_tui.user_code.ros_launch import (
            setup_script,  # Late: a start with --interfaces needs none.
        )

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

    def fill_share_folder(self, prefix: Path) -> None:
        """Fill the share folder below a prefix with links into the sources, unless it is filled.

        It has what setup.py or CMakeLists.txt installs, so what is missing there is missing here.
        Raises ArchoError.
        """
        marker, manifest = prefix / INDEX / self.name, Path("package.xml")
        if not marker.exists():
            # colcon installs the marker and package.xml, whatever setup.py says.
            for source, target in [
                *self._installed_files("FILES", "DIRECTORY"),
                (manifest, "share" / Path(self.name) / manifest),
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
    except ElementTree.ParseError as error:
        raise ArchoError(f"{file}:{error.position[0]}: not XML: {error}") from None
    except (OSError, LookupError, ValueError) as error:
        raise ArchoError(f"{file}: {getattr(error, 'strerror', None) or error}") from None
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


class Workspace:
    """The packages of a workspace, and what can be run of them."""

    def __init__(self, folders: Iterable[Path]) -> None:
        """Read the package.xml of some folders; note in `problems` which cannot be used."""
        self.packages: dict[str, Package] = {}
        self.problems: list[str] = []  # A line for each package.xml that is not used.
        for folder in folders:
            try:
                package = read_package(folder)
            except ArchoError as error:
                self.problems.append(str(error))
                continue
            first = self.packages.setdefault(package.name, package)
            if first is not package:
                text = f"{folder}: another package {package.name}: {first.folder} is taken"
                self.problems.append(text)

    @classmethod
    def below(cls, folder: Path) -> Workspace:
        """Return the workspace with all packages at or below a folder; ArchoError without any."""
        found = cls(_package_folders(folder))
        if not found.packages:
            nothing = f"{folder}: no package: a workspace has src/*/package.xml"
            raise ArchoError((found.problems or [nothing])[0])
        return found

    @classmethod
    def around(cls, file: Path) -> Workspace:
        """Return the workspace around a file: the packages that the file can use, its own first.

        These are all packages below the nearest folder `src/`, else those beside the file's own. A
        file in no package has none.
        """
        above = file.resolve().parents
        own = next((folder for folder in above if (folder / "package.xml").is_file()), None)
        if own is None:
            return cls(())
        root = next((folder for folder in own.parents if folder.name == "src"), None)
        beside = sorted(path.parent for path in own.parent.glob("*/package.xml"))
        return cls(dict.fromkeys([own, *(_package_folders(root) if root else beside)]))

    @cached_property
    def interface_packages(self) -> dict[str, Path]:
        """The folders of the packages with messages, services or actions, by the package's name."""
        packages = self.packages.values()
        return {p.name: p.folder for p in packages if any((p.folder / k).is_dir() for k in KINDS)}

    def find(self, name: str) -> Package | None:
        """Return the package with a name: one of the workspace, or ARCHO's own in a checkout."""
        found = self.packages.get(name)
        return self._own_package if found is None and name == _OWN_PACKAGE else found

    @cached_property
    def _own_package(self) -> Package | None:
        own = _CHECKOUT / "nodes"
        return read_package(own) if (own / "package.xml").is_file() else None

    def nearest_package_hint(self, name: str) -> str:
        """Return ` (nearest: my_robot)` for a misspelt name, or "" if no package has one alike."""
        return nearest_hint(name, self.packages, _ALIKE)

    def entry_point(self, package_name: str, executable: str) -> EntryPoint:
        """Return the function of an executable, or raise ArchoError; may block on a setup.py."""
        package = self.find(package_name)
        if package is None:
            own = f"{_OWN_PACKAGE}.{executable}"  # The console's wheel carries it, but no setup.py.
            if package_name == _OWN_PACKAGE and importlib.util.find_spec(own):
                return EntryPoint(own, "main", "")
            hint = self.nearest_package_hint(package_name) or ": start it with ROS 2"
            raise ArchoError(f"package {package_name} is not here{hint}")
        found = package.executables()
        if executable in found:
            return _checked(found[executable], package, executable)
        if not package.is_python:
            raise ArchoError(
                f"{package_name} is an {package.build_type} package, of which only scripts that "
                f"install(PROGRAMS) names run here: build it and start {executable} with ROS 2"
            )
        near = nearest_hint(executable, found)
        known = "" if near or not found else f" (it has {', '.join(found)})"
        hint = f"{near}{known}: see console_scripts in its setup.py"
        raise ArchoError(f"{package_name} has no executable {executable}{hint}")


def _checked(entry_point: EntryPoint, package: Package, executable: str) -> EntryPoint:
    """Return an entry point if the file of its module is there; raise ArchoError."""
    path = Path(entry_point.module)
    if entry_point.function:
        path = Path(entry_point.source, *entry_point.module.split(".")).with_suffix(".py")
    is_package = (path.with_suffix("") / "__init__.py").is_file()
    if is_package or (path.is_file() and path.suffix == ".py"):
        return entry_point
    near = nearest_hint(path.stem, [file.stem for file in path.parent.glob("*.py")])
    where = f"{executable} in {package.build_file.name} of {package.name}"
    raise ArchoError(f"{where}: there is no Python file {path}{near}")


def _package_folders(folder: Path) -> Iterator[Path]:
    """Yield each package at or below a folder, but none inside another package, as colcon does.

    Hidden and ignored folders, and `build`, `install` and `log` directly in the folder, are left
    out. Links are followed. Raises ArchoError for too many folders.
    """
    seen: set[str] = set()
    for root, names, files in os.walk(folder, followlinks=True):
        real, left_out = os.path.realpath(root), () if seen else _BUILT
        if real in seen or _IGNORED & {*files}:
            names.clear()  # A link to a folder above would never end.
            continue
        seen.add(real)
        if len(seen) > _MAX_FOLDERS:
            raise ArchoError(f"{folder}: more than {_MAX_FOLDERS} folders: name the workspace")
        if "package.xml" in files:
            names.clear()
            yield Path(root)
            continue
        names[:] = sorted(n for n in names if not n.startswith(".") and n not in left_out)
