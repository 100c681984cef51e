"""The commands of the Nodes panel."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from archo_tui.commands.base import IN_PANEL, Command, Desk, Work
from archo_tui.commands.graph import show_topic
from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.station.station import Station
from archo_tui.station.view import View
from archo_tui.text.nodes import NodeRow, node_rows
from archo_tui.user_code.usage import Usage, usage_text
from archo_tui.widgets.nodes_panel import NodesPanel

_USAGE_PERIOD = 1.0  # Seconds between two measurements.
_GONE = "? not on the graph any more"


class _NodeCommand(Command):
    where, panel = IN_PANEL, NodesPanel
    waits_for_answer = True

    def disabled_reason(self, desk: Desk) -> str:
        row = desk.main.nodes.selected
        if row is None:
            return "no node is selected"
        if not desk.main.nodes.shows_cursor:
            return "no node is selected: choose one with ↑ ↓ first"
        if not row.hosted:
            return f"{row.name} does not run in this process"
        return desk.verbs[self.verbs[0]].refusal(desk.station)

    def run_verb(self, desk: Desk, verb: str, hosted: Hosted) -> Work | None:
        """Run a verb on a hosted node, after its question if it has one."""
        return desk.run_verb(desk.verbs[verb], {"node": hosted.name})

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
        return self.run_verb(desk, "halt" if hosted.life.is_running else "start", hosted)


class CopyNode(_NodeCommand):
    id, key, verbs = "copy", "plus", ("copy",)
    help = "Start another copy of the selected node"

    def run(self, desk: Desk) -> Work | None:
        return self.run_verb(desk, "copy", self._selected(desk))


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
    where, panel = IN_PANEL, NodesPanel
    id, key = "details", "enter"
    help = "Show the selected node: its topics, services and log level; after a crash, why"
    verbs = ("log_level", "lifecycle")

    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.main.nodes.selected else "no node is selected"

    def run(self, desk: Desk) -> None:
        row = desk.main.nodes.selected
        assert row is not None
        open_node_dialog(desk, row)


async def _follow_usage(station: Station, name: str, show: Callable[[str], None]) -> None:
    """Show each second what a node or program of this process takes; nothing for any other."""
    before: Usage | None = None
    measured = 0.0
    while (now := await in_daemon(station.host.usage, name)) is not None:
        at = station.clock.monotonic()
        show(usage_text(before, now, at - measured))
        before, measured = now, at
        await station.clock.sleep(_USAGE_PERIOD)


def open_node_dialog(desk: Desk, row: NodeRow) -> None:
    """Open the dialog of a node with its state, topics and services, log level and lifecycle."""
    from archo_tui.screens.node import NodeDialog

    def tell(view: View) -> str:
        now = next((new for new in node_rows(view) if new.name == row.name), None)
        return _GONE if now is None else now.details(view.second, view.snapshot)

    robot, verb, station = desk.station.robot, desk.verbs["log_level"], desk.station

    async def set_level(level: str) -> Outcome:
        return await verb.run(station, {"node": row.name, "level": level})

    def change_lifecycle(word: str) -> Work | None:
        values = {"node": row.name, "transition": word}
        return desk.run_verb(desk.verbs["lifecycle"], values)

    refused = verb.refusal(station)
    describe = partial(robot.describe, row.name)
    desk.live.open(
        NodeDialog(
            row.name,
            tell,
            desk.view,
            describe,
            set_level,
            change_lifecycle,
            refused,
            partial(show_topic, desk),
            partial(_follow_usage, station, row.name),
        )
    )
