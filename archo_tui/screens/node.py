"""One node: how it is doing, what it has on the graph, and the level of its log."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import LEVELS, NodeInfo
from archo_tui.screens.dialog import Dialog
from archo_tui.station.station import View
from archo_tui.terminal.app import COMMANDS, start_worker
from archo_tui.widgets.button import Button
from archo_tui.widgets.styled import content
from archo_tui.words.nodes import graph_lines

_GROUP = "node"  # of workers: the end does not wait for what is only looked at


class NodeDialog(Dialog[None]):
    """The arrows scroll; tab leads to the levels, enter sets one. Escape, enter or q closes it."""

    BINDINGS = [
        ("escape,enter,q", "close", "Close"),
        ("left", "app.focus_previous", "The level before"),
        ("right", "app.focus_next", "The next level"),
    ]

    def __init__(
        self,
        name: str,
        tell: Callable[[View], str],
        view: View,
        describe: Callable[[], Awaitable[NodeInfo | Outcome]],
        set_level: Callable[[str], Awaitable[Outcome]],
        refused: str,
    ) -> None:
        """`tell` says what is known already; `refused` why no level can be set."""
        super().__init__()
        self._node, self._tell, self._view, self._refused = name, tell, view, refused
        self._describe, self._set_level = describe, set_level

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog reading node") as box:
            box.border_title = escape(self._node)
            box.border_subtitle = "esc close"
            with VerticalScroll(classes="question", id="node-text"):
                yield Static(Content(self._tell(self._view)), id="node-known")
                yield Static(Content("asking the graph ..."), id="node-graph")
            yield Static(classes="level")
            with Horizontal(classes="answers", id="levels") as levels:
                levels.display = False
                for level in LEVELS:
                    yield Button(level.capitalize(), partial(self._choose, level), id=level.lower())
            yield Static("", classes="error")

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#node-text"))
        start_worker(self, self._ask, _GROUP)

    def follow(self, view: View) -> None:
        """Bring what is known up to date, once a second."""
        super().follow(view)
        if view.second != self._view.second or view.hosted != self._view.hosted:
            self._view = view
            self.write("#node-known", Content(self._tell(view)))

    async def _ask(self) -> None:
        self._show(await self._describe())

    def _show(self, found: NodeInfo | Outcome) -> None:
        info = found if isinstance(found, NodeInfo) else None
        what = Content(found.text) if isinstance(found, Outcome) else content(graph_lines(found))
        self.write("#node-graph", Content.assemble("\n", what.rstrip()))
        level = None if info is None else info.level
        said = "" if info is None else info.no_level if level is None else level.text
        self.write(".level", Content(f"log level   {said}" if said else ""))
        for line in self.query(".level"):
            line.display = said != ""
        for box in self.query(".node"):
            keys = ("tab log level",) if level is not None and not self._refused else ()
            box.border_subtitle = "   ".join((*keys, "esc close"))
        for levels in self.query("#levels"):
            levels.display = level is not None
        for button in self.query(Button):
            button.set_class(level is not None and button.id == level.own.lower(), "-chosen")
            button.set_class(bool(self._refused), "-blocked")

    def _choose(self, level: str) -> None:
        if not self.is_asking:
            self.is_asking = True
            self.say("asking the node ...")
            start_worker(self.app, partial(self._set, level), COMMANDS)

    async def _set(self, level: str) -> None:
        outcome = await self._set_level(level)
        self.is_asking = False
        if not outcome.ok:
            self.refuse(outcome.text)
            return
        self.say("")
        self._show(await self._describe())
