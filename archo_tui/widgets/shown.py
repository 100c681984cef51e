"""What the screen shows at one moment: the station's view, and the keys of the commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from archo_tui.station.station import View

NONE_RECORDED = "-- none recorded"  # in a list of a replay


@dataclass(frozen=True)
class Shown(View):
    """The station's view, with what only a screen has."""

    keys: Mapping[str, str] = field(default_factory=dict)  # of each command, as a person reads it
    blocked: frozenset[str] = frozenset()  # commands that cannot run now
    is_first: bool = False  # this user has never sent a goal

    def key(self, command: str) -> str:
        """The key of a command, by its id; empty where there is none."""
        return self.keys.get(command, "")
