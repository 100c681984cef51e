"""`--interfaces DIR`: interface packages of the user's own, without colcon."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from archo_tui import embedded, engine
from archo_tui.embedded.import_hook import KINDS, name_of, packages_in
from archo_tui.errors import ArchoError
from archo_tui.hosting.watch import Stamps, stamps


class Found(NamedTuple):
    """Interface packages, and what is wrong with some of them."""

    packages: dict[str, Path]  # by name
    warnings: list[str]  # a line for each package with a mistake, with file and line


def find_all(folders: Sequence[Path], engine_name: str) -> Found:
    """Return the packages of several folders; of two of one name that of the later folder.

    Raises:
        ArchoError: As `find` raises it.
    """
    packages: dict[str, Path] = {}
    warnings: list[str] = []
    for folder in folders:
        found = find(folder, engine_name, packages)
        packages |= found.packages
        warnings += found.warnings
    return Found(packages, warnings)


def find(
    folder: Path, engine_name: str, others: Mapping[str, Path] = MappingProxyType({})
) -> Found:
    """Return the packages of a folder.

    A package with a mistake in one of its interfaces stays: whoever imports that interface is told.

    Args:
        folder: An interface package, or a workspace's `src/`.
        engine_name: The engine that is to read them.
        others: Packages that were found already, whose types these may use.

    Raises:
        ArchoError: There is no package, or none without a mistake, which it names with its line.
    """
    packages: dict[str, Path] = {}
    nameless: list[str] = []
    for place in packages_in(folder) if folder.is_dir() else ():
        try:
            packages[name_of(place)] = place
        except ImportError as error:
            nameless.append(str(error))
    if packages and engine_name != engine.EMBEDDED:
        names = " ".join(packages)
        raise ArchoError(
            "--interfaces is for the embedded engine: on ROS 2 build them, "
            f"colcon build --base-paths {folder} --packages-select {names} && "
            ". install/setup.bash"
        )
    wrong = mistakes({**others, **packages}, packages)
    warnings = [*dict.fromkeys([*nameless, *wrong.values()])]
    if len(wrong) == len(packages):
        nothing = f"{folder}: no interface package: a folder with msg/, srv/ or action/"
        raise ArchoError(warnings[0] if warnings else nothing)
    return Found(packages, warnings)


def mistakes(packages: Mapping[str, Path], of: Iterable[str]) -> dict[str, str]:
    """Read every file of some packages, given all of them.

    Returns:
        The first mistake of each package that has one, with file and line, by the package's name.
    """
    finder, found = embedded.finder(engine.interface_packages(), packages), {}
    for name in of:
        try:
            finder.check(name)
        except ImportError as error:
            found[name] = str(error)
    return found


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
        self._known = mistakes(packages, packages)  # they were named at the start
        self.loaded = self.look()

    def look(self) -> Stamps:
        """Every interface file."""
        folders = self._packages.values()
        return stamps(p for f in folders for kind in KINDS for p in f.glob(f"{kind}/*.{kind}"))

    def reload(self) -> None:
        """Restart, if that is of any use."""
        self.loaded = self.look()
        wrong = mistakes(self._packages, self._packages)
        news = [said for name, said in wrong.items() if said != self._known.get(name)]
        if not news:
            self._restart("interfaces were saved")
        for said in dict.fromkeys(news):
            for name, folder in self._packages.items():  # short: it is one line of the screen
                said = said.replace(str(folder), name)
            self._note("ERROR", "interfaces", f"not read: {said}")
