"""The commands of the Nodes panel."""

from __future__ import annotations

from archo_tui.commands.base import IN_PANEL, Command, Desk, Work
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.widgets.nodes_panel import NodesPanel


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
        open_node_dialog(desk, row.name)


def open_node_dialog(desk: Desk, name: str) -> None:
    """Open the dialog of a node with its state, topics and services, log level and lifecycle."""
    from archo_tui.commands.node_dialog import NodeDialog

    desk.open(NodeDialog(desk, name))
