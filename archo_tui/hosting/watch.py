"""Notices that files were saved, by their times and sizes: that works on every file system."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Protocol

PERIOD = 0.25  # s between two looks
Stamps = dict[Path, tuple[int, int]]  # when each was saved (ns), and its size (bytes)


def stamps(paths: Iterable[Path]) -> Stamps:
    """Of those that are there: an editor may be replacing one just now."""
    found: Stamps = {}
    for path in paths:
        try:
            stat = path.stat()
        except OSError:
            continue
        found[path] = stat.st_mtime_ns, stat.st_size
    return found


class Watched(Protocol):
    """Files that belong together."""

    @property
    def loaded(self) -> Stamps:
        """Of what was last loaded, or tried."""

    def look(self) -> Stamps:
        """As they are now."""

    def reload(self) -> None:
        """Load them as they are now; whatever is wrong with them is said."""


class Watch:
    """A thread that has what was saved reloaded; what is still being written waits for a look."""

    def __init__(self, watched: Sequence[Watched]) -> None:
        self.watched = watched
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="watch", daemon=True)

    def start(self) -> None:
        """Begin, when there is anything to watch."""
        if self.watched:
            self._thread.start()

    def stop(self) -> None:
        """Nothing is reloaded from here on, but what has begun."""
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join(PERIOD)

    def _run(self) -> None:
        before: dict[Watched, Stamps] = {}
        while not self._ends.wait(PERIOD):
            for files in self.watched:
                now = files.look()
                if now != files.loaded and now == before.get(files):
                    files.reload()
                before[files] = now
