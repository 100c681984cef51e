"""`--interfaces DIR`: interface packages of the user's own, without colcon."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from archo_tui import embedded, engine
from archo_tui.embedded.import_hook import KINDS, packages_in
from archo_tui.errors import ArchoError
from archo_tui.hosting.watch import Stamps, stamps


def find_all(folders: Sequence[Path], engine_name: str) -> dict[str, Path]:
    """Return the packages of several folders by name; of two of one name that of the later folder.

    Raises:
        ArchoError: As `find` raises it.
    """
    packages: dict[str, Path] = {}
    for folder in folders:
        packages |= find(folder, engine_name, packages)
    return packages


def find(
    folder: Path, engine_name: str, others: Mapping[str, Path] = MappingProxyType({})
) -> dict[str, Path]:
    """Return the packages of a folder by name.

    Args:
        folder: An interface package, or a workspace's `src/`.
        engine_name: The engine that is to read them.
        others: Packages that were found already, whose types these may use.

    Raises:
        ArchoError: An interface is wrong, with file and line, or there is no package.
    """
    try:
        packages = packages_in(folder) if folder.is_dir() else {}
    except ImportError as error:
        raise ArchoError(str(error)) from None
    if not packages:
        raise ArchoError(f"{folder}: no interface package: a folder with msg/, srv/ or action/")
    if engine_name != engine.EMBEDDED:
        names = " ".join(packages)
        raise ArchoError(
            "--interfaces is for the embedded engine: on ROS 2 build them, "
            f"colcon build --base-paths {folder} --packages-select {names} && "
            ". install/setup.bash"
        )
    check({**others, **packages})
    return packages


def check(packages: Mapping[str, Path]) -> None:
    """Read every file. Raises ArchoError that names file and line."""
    try:
        embedded.finder(engine.interface_packages(), packages).check()
    except ImportError as error:
        raise ArchoError(str(error)) from None


class OwnInterfaces:
    """The files of the packages; all restarts when they were saved and can be read."""

    def __init__(
        self,
        packages: Mapping[str, Path],
        note: Callable[[str, str, str], None],
        restart: Callable[[str], None],
    ) -> None:
        """`note(level, source, text)` says what cannot be read; all goes on as it is then."""
        self._packages, self._note, self._restart = packages, note, restart
        self.loaded = self.look()

    def look(self) -> Stamps:
        """Every interface file."""
        folders = self._packages.values()
        return stamps(p for f in folders for kind in KINDS for p in f.glob(f"{kind}/*.{kind}"))

    def reload(self) -> None:
        """Restart, if that is of any use."""
        self.loaded = self.look()
        try:
            check(self._packages)
        except ArchoError as error:
            said = str(error)
            for name, folder in self._packages.items():  # short: it is one line of the screen
                said = said.replace(str(folder), name)
            self._note("ERROR", "interfaces", f"not read: {said}")
        else:
            self._restart("interfaces were saved")
