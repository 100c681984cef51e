"""Panel 5: who is on the graph."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.content import Content
from textual.widgets import Static

from archo_tui.widgets import words
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.view import View

_WITH_RATE = 33  # columns that a line with its rate needs


class NodesPanel(Panel, can_focus=True):
    """One line a node: when it was last heard, and how often it publishes."""

    number, title_text = 5, "Nodes"

    def __init__(self) -> None:
        super().__init__()
        self._text = ""
        self._drawn: tuple[float, int, int] | None = None

    def compose(self) -> ComposeResult:
        yield Static(id="nodes")

    def show(self, view: View) -> None:
        # once a second is enough for ages: a chatty robot must not become a chatty terminal
        drawn = (view.second, len(view.snapshot.nodes), self.size.width)
        if drawn == self._drawn:
            return
        self._drawn = drawn
        wide = self.size.width >= _WITH_RATE
        lines = [
            words.node_line(node, view.second, with_rate=wide)
            for node in view.snapshot.nodes
            if not node.name.endswith("/archo_console")
        ]
        text = "\n".join(lines) or "? no node on the graph"
        if text != self._text:
            moved = text.count("\n") != self._text.count("\n")
            self._text = text
            self.query_one("#nodes", Static).update(Content(text), layout=moved)
