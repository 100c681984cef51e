"""The commands of Nodes, and the dialog about one node."""

from __future__ import annotations

import asyncio
from functools import partial

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.graph import LEVELS, NodeInfo
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.screen.choose import Choice, Choose
from archo_tui.screen.commands.base import IN_PANEL, Command, Desk, Work
from archo_tui.screen.commands.graph import show_topic
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.terminal.app import COMMANDS, start_worker
from archo_tui.screen.widgets.field import Button
from archo_tui.screen.widgets.line import content
from archo_tui.screen.widgets.nodes_panel import NodesPanel
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.station.view import View
from archo_tui.text.nodes import graph_lines, node_rows
from archo_tui.user_code.usage import usage_text
from archo_tui.verbs.nodes import DuplicateNode


class _NodeCommand(Command):
    where, panel = IN_PANEL, NodesPanel
    waits_for_answer = True

    def disabled_reason(self, desk: Desk) -> str:
        row = desk.main.nodes.selected
        if row is None:
            return "no node is selected"
        if not desk.main.nodes.rows.shows_cursor:
            return "no node is selected: choose one with ↑ ↓ first"
        if not row.hosted:
            return f"{row.name} does not run in this process"
        return desk.verbs[self.verbs[0]].refusal(desk.station)

    def _selected(self, desk: Desk) -> Hosted:
        """Return the selected node, which runs in this process: else the command is disabled."""
        row = desk.main.nodes.selected
        assert row is not None
        assert row.hosted is not None
        return row.hosted


class StartStop(_NodeCommand):
    id, key, verbs = "start_stop", "s", ("start", "halt")
    help = "Start or stop the selected node"

    def run(self, desk: Desk) -> Work | None:
        hosted = self._selected(desk)
        verb = desk.verbs["halt" if hosted.life.is_running else "start"]
        return desk.run_verb(verb, {"node": hosted.name})


class CopyNode(_NodeCommand):
    id, key, verbs = "copy", "plus", ("start",)
    help = "Start another copy of the selected node"

    def run(self, desk: Desk) -> Work | None:
        return desk.run_verb(DuplicateNode(), {"node": self._selected(desk).name})


class Restart(Command):
    where, panel = IN_PANEL, NodesPanel
    id, key = "restart", "ctrl+r"
    help = "Restart for what was saved during a STOP"

    def disabled_reason(self, desk: Desk) -> str:
        if not desk.station.waiting_restart:
            return "no restart waits"
        return desk.station.restart_blocker

    def run(self, desk: Desk) -> None:
        desk.station.restart(desk.station.waiting_restart)


class ShowNode(Command):
    in_replay = True
    where, panel = IN_PANEL, NodesPanel
    id, key = "details", "enter"
    help = "Show the selected node: its topics, services and log level; after a crash, why"
    verbs = ("log_level", "lifecycle")

    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.main.nodes.selected else "no node is selected"

    def run(self, desk: Desk) -> None:
        row = desk.main.nodes.selected
        assert row is not None
        open_node_dialog(desk, row.name)


def open_node_dialog(desk: Desk, name: str) -> None:
    """Open the dialog of a node with its state, topics and services, log level and lifecycle."""
    desk.open(NodeDialog(desk, name))


_USAGE_PERIOD = 1.0  # Seconds between two measurements.
_GONE = "? not on the graph any more"
_GROUP = "node"  # Of workers for whose answers the console's end does not wait.


class NodeDialog(Dialog):
    """The details of a node, with buttons for its log level and its lifecycle."""

    BINDINGS = [
        ("escape,q", "close", "Close"),
        ("enter", "choose_topic", "Look into one of its topics; close if it has none"),
        ("left", "app.focus_previous", "The level before"),
        ("right", "app.focus_next", "The next level"),
    ]

    def __init__(self, desk: Desk, name: str) -> None:
        super().__init__()
        self._desk, self._node, self._view = desk, name, desk.view
        # Of level and lifecycle.
        self._disabled_reason = desk.verbs["log_level"].refusal(desk.station)
        self._topics: dict[str, str] = {}  # The types of those that it publishes or subscribes to.
        self._lifecycle = _lifecycle(desk.view, name)
        self._transitions: tuple[str, ...] = ()
        self._asked = 0  # The questions so far: only the answer to the last one is shown.
        self._replacing = asyncio.Lock()  # Held while the buttons are replaced.

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog reading node") as box:
            box.border_title = escape(self._node)
            box.border_subtitle = "esc close"
            with VerticalScroll(classes="question", id="node-text"):
                yield Static(Content(self._state_text(self._view)), id="node-known")
                usage = Static(id="node-usage")
                usage.display = False
                yield usage
                yield Static(Content("asking the graph ..."), id="node-graph")
            yield Horizontal(classes="answers", id="transitions")
            yield Static(classes="level")
            with Horizontal(classes="answers", id="levels") as levels:
                levels.display = False
                for level in LEVELS:
                    yield Button(level.capitalize(), partial(self._set, level), id=level.lower())
            yield Static("", classes="error")

    def on_mount(self) -> None:
        self.set_focus(self.query_one("#node-text"))
        start_worker(self, self._update_details, _GROUP)
        start_worker(self, self._follow_usage, _GROUP)

    async def _follow_usage(self) -> None:
        """Show each second what a node or program of this process takes; nothing for any other."""
        station, before, measured = self._desk.station, None, 0.0
        while (now := await in_daemon(station.host.usage, self._node)) is not None:
            at = station.clock.monotonic()
            for line in self.query("#node-usage"):
                line.display = True
            text = usage_text(before, now, at - measured)
            self.set_text("#node-usage", Content(f"takes       {text}"))
            before, measured = now, at
            await station.clock.sleep(_USAGE_PERIOD)

    def _state_text(self, view: View) -> str:
        """Return what is known without asking the node."""
        row = next((row for row in node_rows(view) if row.name == self._node), None)
        return _GONE if row is None else row.details(view.second, view.snapshot)

    def show_view(self, view: ScreenState) -> None:
        """Show the state once a second, and when a node here starts or ends.

        When the lifecycle of the node changes, the graph and the node are asked again.
        """
        super().show_view(view)
        before, lifecycle = self._lifecycle, _lifecycle(view, self._node)
        drawn = view.second, view.hosted, lifecycle
        if drawn != (self._view.second, self._view.hosted, before):
            self._view, self._lifecycle = view, lifecycle
            self.set_text("#node-known", Content(self._state_text(view)))
        if lifecycle != before:
            start_worker(self, self._update_details, _GROUP)

    async def _update_details(self) -> None:
        """Ask the graph and the node for the details; show the last answer only."""
        self._asked += 1
        turn = self._asked
        answer = await self._desk.station.robot.describe(self._node)
        if turn == self._asked:
            await self._show(answer)

    async def _show(self, answer: NodeInfo | Outcome) -> None:
        """Show what the node has on the graph, its level and transitions, or why not."""
        if isinstance(answer, Outcome):
            info, text = None, Content(answer.text)
        else:
            info, text = answer, content(graph_lines(answer))
        self._topics = {} if info is None else dict((*info.publishes, *info.subscribes))
        self.set_text("#node-graph", Content.assemble("\n", text.rstrip()))
        level = None if info is None else info.level
        level_text = "" if info is None else info.no_level if level is None else level.text
        self.set_text(".level", Content(f"log level   {level_text}" if level_text else ""))
        for line in self.query(".level"):
            line.display = level_text != ""
        for box in self.query(".node"):
            can_set = level is not None and not self._disabled_reason
            keys = ["enter topics"] if self._topics else []
            keys += ["tab log level"] if can_set else []
            box.border_subtitle = "   ".join((*keys, "esc close"))
        await self._show_transitions(() if info is None else info.transitions)
        for levels in self.query("#levels"):
            levels.display = level is not None
        for button in self.query(Button):
            button.set_class(level is not None and button.id == level.own.lower(), "-chosen")
            button.set_class(bool(self._disabled_reason), "-blocked")

    async def _show_transitions(self, words: tuple[str, ...]) -> None:
        """Show a button for each transition that the node can make now; none hides the row."""
        async with self._replacing:
            for box in self.query("#transitions"):
                box.display = bool(words)
                if words == self._transitions:
                    continue
                self._transitions = words
                await box.remove_children()
                if box.is_attached:
                    await box.mount(*map(self._button, range(len(words)), words))

    def action_choose_topic(self) -> None:
        """List the node's topics to open one of them; while none is known, close the dialog."""
        if not self._topics:
            self.dismiss()
            return
        rows = [
            Choice(name, partial(show_topic, self._desk, name, types.split(", ")), types)
            for name, types in sorted(self._topics.items())
        ]
        self.app.push_screen(Choose(f"Topics of {self._node.lstrip('/')}", rows))

    def _button(self, place: int, word: str) -> Button:
        return Button(word.capitalize(), partial(self._change, word), id=f"transition-{place}")

    def _change(self, word: str) -> None:
        if self._disabled_reason:
            self.refuse(self._disabled_reason)
            return
        values = {"node": self._node, "transition": word}
        work = self._desk.run_verb(self._desk.verbs["lifecycle"], values)
        if work is not None:
            start_worker(self.app, lambda: work, COMMANDS)

    def _set(self, level: str) -> None:
        values = {"node": self._node, "level": level}
        send = partial(self._desk.verbs["log_level"].run, self._desk.station, values)
        self.ask(send, self._show_level, "asking the node ...")

    def _show_level(self, outcome: Outcome) -> None:
        if not outcome.ok:
            self.refuse(outcome.text)
        else:
            self.show_message("")
            start_worker(self, self._update_details, _GROUP)


def _lifecycle(view: View, name: str) -> str:
    return next((node.lifecycle for node in view.snapshot.nodes if node.name == name), "")
