"""The packages of a workspace, found as colcon finds them, and what can be run of them."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path

from archo_tui.errors import ArchoError
from archo_tui.launch.package import EntryPoint, Package, read_package
from archo_tui.nearest import nearest_hint

_IGNORED = ("COLCON_IGNORE", "AMENT_IGNORE")  # A folder with such a file is left out.
_BUILT = ("build", "install", "log")  # What colcon makes beside src/.
_MAX_FOLDERS = 20_000  # A home folder is no workspace.
_ALIKE = 0.8  # Above difflib's 0.6, as packages of one project have names that are alike.
_OWN_PACKAGE = "archo_bringup"
_CHECKOUT = Path(__file__).parent.parent.parent


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
        if root is not None:
            return cls(dict.fromkeys([own, *_package_folders(root)]))
        beside = sorted(path.parent for path in own.parent.glob("*/package.xml"))
        return cls(dict.fromkeys([own, *beside]))

    @cached_property
    def interface_packages(self) -> dict[str, Path]:
        """The folders of the packages with messages, services or actions, by the package's name."""
        return {p.name: p.folder for p in self.packages.values() if p.has_interfaces}

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
            if package_name == _OWN_PACKAGE and executable in _carried_nodes():
                return EntryPoint(f"{_OWN_PACKAGE}.{executable}", "main", "")
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
    if not entry_point.function:
        script = Path(entry_point.module)
        if script.is_file() and script.suffix == ".py":
            return entry_point
        why = "is no Python file" if script.is_file() else "is not there"
        raise ArchoError(f"{executable} in CMakeLists.txt of {package.name}: {script} {why}")
    path = Path(entry_point.source, *entry_point.module.split("."))
    if path.with_suffix(".py").is_file() or (path / "__init__.py").is_file():
        return entry_point
    near = nearest_hint(path.name, [p.stem for p in path.parent.glob("*.py")])
    target = f"{entry_point.module}:{entry_point.function}"
    file = f"{entry_point.module.replace('.', '/')}.py"
    raise ArchoError(
        f"{executable} = {target} in setup.py of {package.name}: there is no {file}{near}"
    )


def _carried_nodes() -> list[str]:
    """Return the names of ARCHO's nodes: the console's wheel carries them, without a setup.py."""
    spec = importlib.util.find_spec(_OWN_PACKAGE)
    folders = (spec and spec.submodule_search_locations) or ()
    return [path.stem for folder in folders for path in Path(folder).glob("*.py")]


def _package_folders(folder: Path) -> Iterator[Path]:
    """Yield each package at or below a folder, but none inside another package, as colcon does.

    Hidden and ignored folders, and `build`, `install` and `log` directly in the folder, are left
    out. Links are followed. Raises ArchoError for too many folders.
    """
    seen: set[str] = set()
    for root, names, files in os.walk(folder, followlinks=True):
        real = os.path.realpath(root)
        is_first = os.path.samefile(root, folder)
        if real in seen or any(name in files for name in _IGNORED):
            names.clear()  # A link to a folder above would never end.
            continue
        seen.add(real)
        if len(seen) > _MAX_FOLDERS:
            raise ArchoError(f"{folder}: more than {_MAX_FOLDERS} folders: name the workspace")
        if "package.xml" in files:
            names.clear()
            yield Path(root)
            continue
        left_out = _BUILT if is_first else ()
        names[:] = sorted(n for n in names if not n.startswith(".") and n not in left_out)
