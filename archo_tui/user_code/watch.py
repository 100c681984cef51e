"""A thread that reloads files when they were saved.

It compares times and sizes, which works on every file system.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Protocol

from archo_tui.base.errors import in_one_line

PERIOD = 0.25  # Seconds between two comparisons.
# When each file was saved, as Unix time in nanoseconds, and its size in bytes.
Stamps = dict[Path, tuple[int, int]]


def stamps(paths: Iterable[Path]) -> Stamps:
    """Return the stamps of files, by path: the time in ns when each was saved, and its size.

    Files that are missing or cannot be read are left out: an editor may be replacing them.
    """
    found: Stamps = {}
    for path in paths:
        try:
            stat = path.stat()
        except OSError:
            continue
        found[path] = stat.st_mtime_ns, stat.st_size
    return found


class Watched(Protocol):
    """Files that are reloaded together, once `current_stamps` differs from `loaded`."""

    @property
    def loaded(self) -> Stamps:
        """The stamps of the files when they were last loaded, or could not be loaded."""

    def current_stamps(self) -> Stamps:
        """Return the stamps of the files as they are now."""


class FileWatcher:
    """A thread that calls the reload of files that were saved.

    A file that is still being written is reloaded once it is the same in two comparisons.
    """

    def __init__(
        self,
        watched: Sequence[tuple[Watched, Callable[[], object]]],
        on_error: Callable[[str], None],
    ) -> None:
        self.watched, self._on_error = watched, on_error
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="watch", daemon=True)

    def start(self) -> None:
        """Start the thread, if there is anything to watch."""
        if self.watched:
            self._thread.start()

    def stop(self) -> None:
        """End the thread; a reload that has begun goes on, and is awaited for PERIOD at most."""
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join(PERIOD)

    def _run(self) -> None:
        before: dict[Watched, Stamps] = {}
        failed: dict[Watched, Stamps] = {}  # What could not be reloaded is tried when saved anew.
        while not self._ends.wait(PERIOD):
            for files, reload in self.watched:
                now = files.current_stamps()
                is_due = now != files.loaded and now == before.get(files)
                before[files] = now
                if is_due and now != failed.get(files):
                    try:
                        reload()
                    except Exception as error:  # As of a full disk: other files go on.
                        failed[files] = now
                        self._on_error(f"a saved file was not reloaded: {in_one_line(error)}")
