"""`--interfaces DIR`: interface packages of the user's own, without colcon."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path

from archo_tui import embedded, engine
from archo_tui.embedded.interfaces import KINDS, packages_in
from archo_tui.errors import ArchoError

PERIOD = 0.25  # s between two looks
Stamps = dict[Path, tuple[int, int]]


def find(folder: Path, engine_name: str) -> dict[str, Path]:
    """The packages by name. Raises ArchoError, with file and line where an interface is wrong."""
    packages = packages_in(folder) if folder.is_dir() else {}
    if not packages:
        raise ArchoError(f"{folder}: no interface package: a folder with msg/, srv/ or action/")
    if engine_name != engine.EMBEDDED:
        names = " ".join(packages)
        raise ArchoError(
            "--interfaces is for the embedded engine: on ROS 2 build them, "
            f"colcon build --base-paths {folder} --packages-select {names} && "
            ". install/setup.bash"
        )
    check(packages)
    return packages


def check(packages: Mapping[str, Path]) -> None:
    """Read every file. Raises ArchoError that names file and line."""
    try:
        embedded.finder(engine.interface_packages(), packages).check()
    except ImportError as error:
        raise ArchoError(str(error)) from None


class InterfaceWatch:
    """Notices what is saved; `changed()` is called when all of it can be read."""

    def __init__(
        self,
        packages: Mapping[str, Path],
        note: Callable[[str, str, str], None],
        changed: Callable[[], None],
    ) -> None:
        """`note(level, source, text)` says what cannot be read; all goes on as it is then."""
        self._packages, self._note, self._changed = packages, note, changed
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="interfaces", daemon=True)

    def start(self) -> None:
        """Begin to watch, when there is anything to watch."""
        if self._packages:
            self._thread.start()

    def stop(self) -> None:
        """No more restarts."""
        self._ends.set()

    def _run(self) -> None:
        loaded = before = self._look()
        while not self._ends.wait(PERIOD):
            now = self._look()
            if now != loaded and now == before:  # and not still being written
                loaded = now
                self._try()
            before = now

    def _try(self) -> None:
        try:
            check(self._packages)
        except ArchoError as error:
            said = str(error)
            for name, folder in self._packages.items():  # short: it is one line of the screen
                said = said.replace(str(folder), name)
            self._note("ERROR", "interfaces", f"not read: {said}")
        else:
            self._note("YOU", "console", "interfaces were saved: all nodes restart")
            self._changed()

    def _look(self) -> Stamps:
        found: Stamps = {}
        for folder in self._packages.values():
            for path in (p for kind in KINDS for p in folder.glob(f"{kind}/*.{kind}")):
                try:
                    stat = path.stat()
                except OSError:  # an editor may be replacing it just now
                    continue
                found[path] = stat.st_mtime_ns, stat.st_size
        return found
