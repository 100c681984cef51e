"""What the screen shows at one moment: the station's view, and the keys of the commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from archo_tui.station import View


@dataclass(frozen=True)
class Shown(View):
    """The station's view, with what only a screen has."""

    keys: Mapping[str, str] = field(default_factory=dict)  # of each command, as a person reads it
    blocked: frozenset[str] = frozenset()  # commands that cannot run now

    def key(self, command: str) -> str:
        """The key of a command, by its id."""
        return self.keys[command]
