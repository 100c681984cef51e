"""A folder that looks like a workspace's `install/`, made of links into the sources.

It has what each setup.py names in `data_files`, so what is missing there is missing here.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from archo_tui.errors import ArchoError
from archo_tui.launch import cmake
from archo_tui.launch.package import AMENT_PYTHON, Package
from archo_tui.launch.setup_script import run_setup

_INDEX = Path("share", "ament_index", "resource_index", "packages")


def share_folder(prefix: Path, package: Package) -> Path:
    """Return a package's share folder of links; the first call may run its setup.py, and blocks."""
    share = prefix / "share" / package.name
    marker = prefix / _INDEX / package.name
    if not marker.exists():
        for source, target in _installed_files(package):
            _link(package.folder / source, prefix / target)
        # colcon installs these two, whatever setup.py says.
        _link(package.folder / "package.xml", share / "package.xml")
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()
    return share


def missing_file_text(prefix: Path, package: Package, path: Path) -> str:
    """Return why a file is missing in a package's share folder; "" for a path outside of it."""
    try:
        inside = path.relative_to(prefix / "share" / package.name)
    except ValueError:
        return ""
    file = "setup.py" if package.build_type == AMENT_PYTHON else "CMakeLists.txt"
    if not (package.folder / inside).is_file():
        return f"{package.name} has no {inside.as_posix()}"
    rule = "name it in data_files" if file == "setup.py" else "name its folder in install(DIRECTORY"
    return f"{file} of {package.name} does not install {inside.as_posix()}: {rule}"


def _installed_files(package: Package) -> Iterator[tuple[Path, Path]]:
    """Yield each installed file: its path in the package's folder, and that below the prefix."""
    if package.build_type == AMENT_PYTHON:
        for folder, names in run_setup(package).data_files:
            for name in names:
                # setuptools refuses such a file, too, when the package is built.
                if not (package.folder / name).is_file():
                    setup = package.folder / "setup.py"
                    raise ArchoError(f"{setup}: data_files: {name} is no file")
                yield Path(name), Path(folder, Path(name).name)
        return
    for found in cmake.installs(package):
        for name in found.names:
            if found.kind != "DIRECTORY":
                yield Path(name), Path(found.destination, found.rename or Path(name).name)
                continue
            # `DIRECTORY launch` installs the folder, `DIRECTORY launch/` what is in it.
            root = package.folder / name
            base = root if name.endswith("/") else root.parent
            for path in sorted(p for p in root.rglob("*") if p.is_file()):
                target = Path(found.destination) / path.relative_to(base)
                yield path.relative_to(package.folder), target


def _link(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        if not target.exists():
            os.symlink(source.resolve(), target)
    except OSError:  # Windows allows links to few users.
        shutil.copyfile(source, target)
