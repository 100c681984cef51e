"""What reaches somebody who looks elsewhere: the bell, and a notice of the desktop."""

from __future__ import annotations

import os
from collections.abc import Mapping

from archo_tui.robot.text import harmless

_TITLE = "archo-tui"
# by what tells a terminal: which of the three sequences it knows. tmux and screen pass none on
_OSC_9 = ("iTerm.app", "WezTerm", "WarpTerminal", "ghostty")  # TERM_PROGRAM
_OSC_777 = ("foot", "rxvt")  # TERM


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
