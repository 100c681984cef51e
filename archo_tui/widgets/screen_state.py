"""The state that the screen shows: the station's view, and the keys of the commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from archo_tui.station.alarms import Alarm, advice, remedy_hints
from archo_tui.station.view import View

NONE_RECORDED = "-- none recorded"  # The text of an empty list in a replay.


@dataclass(frozen=True)
class ScreenState(View):
    """The station's view, with what only a screen needs."""

    # By the command's id, as a person reads it.
    keys: Mapping[str, str] = field(default_factory=dict)
    blocked: frozenset[str] = frozenset()  # The ids of the commands that cannot run now.
    # The ids of the commands whose keys the focused field takes as text, and of what it is for.
    typed: frozenset[str] = frozenset()

    def advice(self, alarm: Alarm) -> str:
        """Return the text of an alarm, with the key of the command that helps if it can run now."""
        names = [name for name, key in self.keys.items() if key and name not in self.blocked]
        hints = {name: f"press {self.key_to_press(name)}" for name in names}
        return advice(alarm, remedy_hints(self.snapshot, hints))

    def key_to_press(self, command: str) -> str:
        """Return the key of a command, behind `esc` while it is text; "" if it has none."""
        key = self.key(command)
        return f"esc {key}" if key and command in self.typed else key

    def key(self, command: str) -> str:
        """Return the key of a command by its id, or "" if it has none."""
        return self.keys.get(command, "")
