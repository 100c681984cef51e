"""Watches the user's own node files: what was saved runs within a second."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from archo_tui.host import Host
from archo_tui.node_files import NodeFile, Stamps

PERIOD = 0.25  # s between two looks; a text that is still being written is left for the next


class Reloader:
    """A thread that looks at times and sizes: it works on every file system, and costs little."""

    def __init__(
        self, host: Host, files: Sequence[NodeFile], kept: Callable[[str], Mapping[str, Any]]
    ) -> None:
        """`kept(node)` are the parameters that the operator has set."""
        self._host, self._files, self._kept = host, files, kept
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="reloader", daemon=True)

    def start(self) -> None:
        """Begin to watch, when there is anything to watch."""
        if self._files:
            self._thread.start()

    def stop(self) -> None:
        """No more restarts from here on."""
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join(PERIOD)

    def _run(self) -> None:
        before: dict[NodeFile, Stamps] = {}
        while not self._ends.wait(PERIOD):
            for file in self._files:
                now = file.look()
                if now != file.loaded and now == before.get(file):
                    self._host.reload(file, self._kept)
                before[file] = now
