"""The user's own interface packages, which `--interfaces DIR` reads without colcon."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from archo_tui import embedded, engine
from archo_tui.embedded.import_hook import KINDS, name_of, packages_in
from archo_tui.errors import ArchoError
from archo_tui.user_code.watch import Stamps, stamps


class Found(NamedTuple):
    """The interface packages that were found in folders.

    Attributes:
        packages: The folders of the packages, by name.
        warnings: A line for each package with a mistake, which names file and line.
    """

    packages: dict[str, Path]
    warnings: list[str]


def find_all(folders: Sequence[Path], engine_name: str) -> Found:
    """Find the packages in several folders; a later folder's package replaces one of the same name.

    Args:
        folders: Interface packages, or the `src/` of workspaces.
        engine_name: The engine that is to read them.

    Raises:
        ArchoError: A folder has no package without a mistake, or the engine is ROS 2; see `find`.
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
    """Find the packages in a folder, and read their interfaces.

    A package with a mistake in an interface is found, too: importing that interface raises.

    Args:
        folder: An interface package, or a workspace's `src/`.
        engine_name: The engine that is to read them.
        others: Packages that were found before, whose types these may use.

    Raises:
        ArchoError: There is no package; each package has a mistake, the first of which is the
            text; or the engine is ROS 2, where packages have to be built.
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
    """Read every interface file of some packages, and return the mistakes.

    Args:
        packages: The folders of all packages, whose types the files may use, by name.
        of: The names of the packages to read.

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
    """The watched interface files of the user: the console restarts when one is saved."""

    def __init__(
        self,
        packages: Mapping[str, Path],
        note: Callable[[str, str, str], None],
        restart: Callable[[str], None],
    ) -> None:
        """Watch packages.

        Args:
            packages: The folders of the packages, by name.
            note: Gets level, source and text of an event about a file that cannot be read. The
                console goes on with the old types then.
            restart: Restarts the console, given the reason.
        """
        self._packages, self._note, self._restart = packages, note, restart
        self._known = mistakes(packages, packages)  # The start has named these.
        self.loaded = self.current_stamps()

    def current_stamps(self) -> Stamps:
        """Return the stamps of every interface file."""
        folders = self._packages.values()
        return stamps(p for f in folders for kind in KINDS for p in f.glob(f"{kind}/*.{kind}"))

    def reload(self) -> None:
        """Restart the console, unless the files have mistakes that the start did not name.

        Each such mistake becomes an error event.
        """
        self.loaded = self.current_stamps()
        wrong = mistakes(self._packages, self._packages)
        new_mistakes = [text for name, text in wrong.items() if text != self._known.get(name)]
        if not new_mistakes:
            self._restart("interfaces were saved")
        for text in dict.fromkeys(new_mistakes):
            for name, folder in self._packages.items():  # An event has one line of the screen.
                text = text.replace(str(folder), name)
            self._note("ERROR", "interfaces", f"not read: {text}")
