"""Desktop notifications, for an operator who looks elsewhere."""

from __future__ import annotations

import os
from collections.abc import Mapping

from archo_tui.safe_text import harmless

_TITLE = "archo-tui"
# The terminals that know a sequence. Inside tmux and screen none of them arrives.
_OSC_9 = ("iTerm.app", "WezTerm", "WarpTerminal", "ghostty")  # Values of TERM_PROGRAM.
_OSC_777 = ("foot", "rxvt")  # Beginnings of TERM.


def desktop_notification(text: str, environ: Mapping[str, str] = os.environ) -> str:
    """Return the escape sequence for a notification; "" for a terminal not known to have one."""
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
