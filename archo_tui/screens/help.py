"""All keys, from the one registry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.widgets import Static

from archo_tui.screens.dialog import Dialog

_INTRODUCTION = (
    "STOP is a software stop: it does not replace the hardware emergency stop. "
    "tab moves on, enter presses or edits, esc leads out; while you type, letters are text."
)


class Entry(NamedTuple):
    """What is said about one key."""

    key: str
    help: str
    place: str  # where it works, empty for wherever no text is typed
    reason: str  # why it cannot run now, or empty


class Help(Dialog[None]):
    """One line a command, with the reason when it cannot run now."""

    BINDINGS = [("escape,question_mark,q", "close", "Close")]

    def __init__(self, entries: Sequence[Entry]) -> None:
        super().__init__()
        self._entries = entries

    def compose(self) -> ComposeResult:
        with VerticalScroll(classes="dialog keys") as box:
            box.border_title = "Keys"
            box.border_subtitle = "esc close"
            yield Static(Content(_INTRODUCTION))
            for entry in self._entries:
                yield Static(_line(entry))


def _line(entry: Entry) -> Content:
    key = Content.styled(f"{entry.key:>5}", "$quiet" if entry.reason else "bold")
    text = f"  {entry.help}" + (f" ({entry.place})" if entry.place else "")
    if entry.reason:
        return Content.assemble(key, (f"{text}: {entry.reason}", "$quiet"))
    return Content.assemble(key, text)
