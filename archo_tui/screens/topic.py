"""The dialog about one topic: its type and rate, and its ends with their QoS."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import TopicInfo
from archo_tui.screens.dialog import Dialog
from archo_tui.screens.text import ShowText
from archo_tui.terminal.app import start_worker
from archo_tui.widgets.styled import content
from archo_tui.words.graph import topic_lines

_GROUP = "topic"  # Of workers for whose answers the console's end does not wait.


class TopicDialog(Dialog[None]):
    """A text that the arrows scroll; escape, enter and q close it, and t shows the type."""

    BINDINGS = [
        ("escape,enter,q", "close", "Close"),
        ("t", "show_type", "The definition of the type"),
    ]

    def __init__(
        self,
        name: str,
        known: str,
        ask: Callable[[], Awaitable[TopicInfo | Outcome]],
        read_type: Callable[[], Awaitable[str]],
    ) -> None:
        """Create the dialog.

        Args:
            name: The full name of the topic.
            known: What is known without asking the graph.
            ask: Asks the graph for the ends of the topic.
            read_type: Returns the definition of its type.
        """
        super().__init__()
        self._read_type = read_type
        self._topic, self._known, self._ask = name, known, ask

    def body(self) -> ComposeResult:
        with VerticalScroll(classes="dialog reading") as box:
            box.border_title = escape(self._topic)
            box.border_subtitle = "t type   esc close"
            yield Static(Content(self._known))
            yield Static(Content("asking the graph ..."), id="topic-ends")

    def on_mount(self) -> None:
        start_worker(self, self._show_ends, _GROUP)

    async def _show_ends(self) -> None:
        answer = await self._ask()
        text = Content(answer.text) if isinstance(answer, Outcome) else content(topic_lines(answer))
        self.set_text("#topic-ends", Content.assemble("\n", text.rstrip()))

    def action_show_type(self) -> None:
        """Show the definition of the type, in a dialog over this one."""
        if not self.is_asking:
            self.is_asking = True
            start_worker(self, self._show_type, _GROUP)

    async def _show_type(self) -> None:
        text = await self._read_type()
        self.is_asking = False
        if not self.has_left:
            self.app.push_screen(ShowText(self._topic, text))
