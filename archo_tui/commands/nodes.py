"""The commands of the Nodes panel."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from archo_tui.commands.base import IN_PANEL, NODES, Command, Console, Work
from archo_tui.commands.graph import show_topic
from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.station.station import Station
from archo_tui.station.view import View
from archo_tui.text.nodes import NodeRow, node_rows
from archo_tui.user_code.usage import Usage, usage_text

_USAGE_PERIOD = 1.0  # Seconds between two measurements.
_GONE = "? not on the graph any more"


class _NodeCommand(Command):
    where, panel = IN_PANEL, NODES
    waits_for_answer = True

    def disabled_reason(self, console: Console) -> str:
        row = console.main.nodes.selected
        if row is None:
            return "no node is selected"
        if not console.main.nodes.shows_cursor:
            return "no node is selected: choose one with ↑ ↓ first"
        if not row.hosted:
            return f"{row.name} does not run in this process"
        return console.verbs[self.verbs[0]].refusal(console.station)

    def run_verb(self, console: Console, verb: str, hosted: Hosted) -> Work | None:
        """Run a verb on a hosted node, after its question if it has one."""
        return console.run_verb(console.verbs[verb], {"node": hosted.name})

    def _selected(self, console: Console) -> Hosted:
        """Return the selected node, which runs in this process: else the command is disabled."""
        row = console.main.nodes.selected
        assert row is not None
        assert row.hosted is not None
        return row.hosted


class StartStop(_NodeCommand):
    id, key, verbs = "start_stop", "s", ("start", "halt")
    help = "Start or stop the selected node"

    def run(self, console: Console) -> Work | None:
        hosted = self._selected(console)
        return self.run_verb(console, "halt" if hosted.life.is_running else "start", hosted)


class CopyNode(_NodeCommand):
    id, key, verbs = "copy", "plus", ("copy",)
    help = "Start another copy of the selected node"

    def run(self, console: Console) -> Work | None:
        return self.run_verb(console, "copy", self._selected(console))


class Restart(Command):
    where, panel = IN_PANEL, NODES
    id, key = "restart", "ctrl+r"
    help = "Restart for what was saved during a STOP"

    def disabled_reason(self, console: Console) -> str:
        if not console.station.waiting_restart:
            return "no restart waits"
        return console.station.restart_blocker

    def run(self, console: Console) -> None:
        console.station.restart(console.station.waiting_restart)


class ShowNode(Command):
    where, panel = IN_PANEL, NODES
    id, key = "details", "enter"
    help = "Show the selected node: its topics, services and log level; after a crash, why"
    verbs = ("log_level", "lifecycle")

    def disabled_reason(self, console: Console) -> str:
        return "" if console.main.nodes.selected else "no node is selected"

    def run(self, console: Console) -> None:
        row = console.main.nodes.selected
        assert row is not None
        open_node_dialog(console, row)


async def _follow_usage(station: Station, name: str, show: Callable[[str], None]) -> None:
    """Show each second what a node or program of this process takes; nothing for any other."""
    before: Usage | None = None
    measured = 0.0
    while (now := await in_daemon(station.host.usage, name)) is not None:
        at = station.clock.monotonic()
        show(usage_text(before, now, at - measured))
        before, measured = now, at
        await station.clock.sleep(_USAGE_PERIOD)


def open_node_dialog(console: Console, row: NodeRow) -> None:
    """Open the dialog of a node with its state, topics and services, log level and lifecycle."""
    from archo_tui.screens.node import NodeDialog

    def tell(view: View) -> str:
        now = next((new for new in node_rows(view) if new.name == row.name), None)
        return _GONE if now is None else now.details(view.second, view.snapshot)

    robot, verb, station = console.station.robot, console.verbs["log_level"], console.station

    async def set_level(level: str) -> Outcome:
        return await verb.run(station, {"node": row.name, "level": level})

    def change_lifecycle(word: str) -> Work | None:
        values = {"node": row.name, "transition": word}
        return console.run_verb(console.verbs["lifecycle"], values)

    refused = verb.refusal(station)
    describe = partial(robot.describe, row.name)
    console.open(
        NodeDialog(
            row.name,
            tell,
            console.view,
            describe,
            set_level,
            change_lifecycle,
            refused,
            partial(show_topic, console),
            partial(_follow_usage, station, row.name),
        )
    )
