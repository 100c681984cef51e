"""The user's own interface packages, which `--interfaces DIR` reads without colcon."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from archo_tui.base.errors import ArchoError
from archo_tui.ros import embedded, engine
from archo_tui.ros.embedded.idl import is_package_name
from archo_tui.ros.embedded.import_hook import NEEDED, has_interfaces
from archo_tui.ros.names import KINDS
from archo_tui.user_code.watch import Stamps, stamps


class InterfacePackages(NamedTuple):
    """The interface packages that were found in folders."""

    packages: dict[str, Path]  # The folders of the packages, by name.
    warnings: list[str]  # A line for each package with a mistake, which names file and line.


def find(folders: Iterable[Path], engine_name: str) -> InterfacePackages:
    """Find the interface packages in folders; of several with one name the last counts.

    A package with a mistake gets a warning. ArchoError if all packages of a folder have one, if it
    has none, or on ROS 2, where packages have to be built.
    """
    packages: dict[str, Path] = {}
    warnings: dict[str, None] = {}
    for folder in folders:
        found: dict[str, Path] = {}
        texts: list[str] = []
        for place in _folders(folder):
            try:
                found[_name_of(place)] = place
            except ArchoError as error:
                texts.append(str(error))
        if found and engine_name != engine.EMBEDDED:
            raise ArchoError(
                "--interfaces is for the embedded engine: on ROS 2 build them, "
                f"colcon build --base-paths {folder} --packages-select {' '.join(found)} && "
                ". install/setup.bash"
            )
        packages |= found
        wrong = mistakes(packages, found)
        texts += wrong.values()
        if len(wrong) == len(found):
            nothing = f"{folder}: no interface package: a folder with msg/, srv/ or action/"
            raise ArchoError(texts[0] if texts else nothing)
        warnings |= dict.fromkeys(texts)
    return InterfacePackages(packages, list(warnings))


def _folders(folder: Path) -> list[Path]:
    """Return the interface packages in a folder: the folder itself, then those below, sorted."""
    places = dict.fromkeys([folder, *sorted(p.parent for p in folder.glob("**/package.xml"))])
    return [place for place in places if has_interfaces(place)]


def _name_of(place: Path) -> str:
    """Return the name of an interface package, which its messages can have; raise ArchoError."""
    from archo_tui.user_code.ros_launch.workspace import read_package

    name, file = read_package(place).name, place / "package.xml"
    if not is_package_name(name):
        rule = "small letters, digits and single _"
        raise ArchoError(f"{file}:1: {name!r} is not a name of a package: {rule}")
    if name in NEEDED:
        raise ArchoError(f"{file}:1: the engine needs {name} as it is: take another name")
    return name


def mistakes(packages: Mapping[str, Path], of: Iterable[str]) -> dict[str, str]:
    """Read the interface files of some packages; return the first mistake of each that has one."""
    finder, found = embedded.finder(engine.interface_packages(), packages), {}
    for name in of:
        try:
            finder.check(name)
        except ImportError as error:
            found[name] = str(error)
    return found


class OwnInterfaces:
    """The watched interface files of the user: the console restarts when one is saved."""

    def __init__(self, packages: Mapping[str, Path]) -> None:
        self._packages = packages
        self._known = mistakes(packages, packages)  # The start has named these.
        self.loaded = self.current_stamps()

    def current_stamps(self) -> Stamps:
        """Return the stamps of every interface file."""
        folders = self._packages.values()
        return stamps(p for f in folders for kind in KINDS for p in f.glob(f"{kind}/*.{kind}"))

    def reload(self, note: Callable[[str, str, str], None], restart: Callable[[str], None]) -> None:
        """Restart the console, unless the files have mistakes that the start did not name.

        Each such mistake becomes an error event.
        """
        self.loaded = self.current_stamps()
        wrong = mistakes(self._packages, self._packages)
        new_mistakes = [text for name, text in wrong.items() if text != self._known.get(name)]
        if not new_mistakes:
            restart("interfaces were saved")
        for text in dict.fromkeys(new_mistakes):
            for name, folder in self._packages.items():  # An event has one line of the screen.
                text = text.replace(str(folder), name)
            note("ERROR", "interfaces", f"not read: {text}")
