"""What reaches somebody who looks elsewhere: the bell, and a notice of the desktop."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

from archo_tui.alarms import Alarm, Priority, State
from archo_tui.robot.text import harmless

_TITLE = "archo-tui"
# by what tells a terminal: which of the three sequences it knows. tmux and screen pass none on
_OSC_9 = ("iTerm.app", "WezTerm", "WarpTerminal", "ghostty")  # TERM_PROGRAM
_OSC_777 = ("foot", "rxvt")  # TERM


class Ringer:
    """Says of which alarms somebody is to be told: grave ones, each once while it stands."""

    def __init__(self) -> None:
        self._told: set[str] = set()

    def news(self, alarms: Iterable[Alarm]) -> list[Alarm]:
        """Those of all the alarms that are new and grave."""
        standing = {alarm.name: alarm for alarm in alarms}
        self._told &= standing.keys()
        found = [
            alarm
            for name, alarm in standing.items()
            if alarm.priority == Priority.HIGH
            and alarm.state == State.UNACKNOWLEDGED
            and name not in self._told
        ]
        self._told.update(alarm.name for alarm in found)
        return found


def notice(text: str, environ: Mapping[str, str] = os.environ) -> str:
    """What has the terminal show a notice; an empty string where it is not known to."""
    text = harmless(text).replace(";", ",")
    term, program = environ.get("TERM", ""), environ.get("TERM_PROGRAM", "")
    if term.startswith(("tmux", "screen")):
        return ""
    if term == "xterm-kitty":
        return f"\x1b]99;;{_TITLE}: {text}\x1b\\"
    if program in _OSC_9:
        return f"\x1b]9;{_TITLE}: {text}\x07"
    if term.startswith(_OSC_777) or "VTE_VERSION" in environ:
        return f"\x1b]777;notify;{_TITLE};{text}\x1b\\"
    return ""
