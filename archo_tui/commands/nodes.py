"""Commands of the nodes' panel."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from archo_tui.commands.base import IN_PANEL, NODES, Command, Console
from archo_tui.robot.state import Hosted, Life, Outcome
from archo_tui.screens.confirm import Confirm
from archo_tui.screens.text import ShowText
from archo_tui.widgets.nodes_panel import NodeRow


class _InNodes(Command):
    where, panel = IN_PANEL, NODES

    def blocked(self, console: Console) -> str:
        row = console.main.nodes.selected
        if row is None:
            return "no node is selected"
        return "" if row.hosted else f"{row.name} does not run in this process"

    def _selected(self, console: Console) -> tuple[NodeRow, Hosted]:
        """The selected node of this process: without one the command is blocked."""
        row = console.main.nodes.selected
        assert row is not None
        assert row.hosted is not None
        return row, row.hosted

    async def _do(
        self, console: Console, title: str, work: Callable[[str], Outcome], hosted: Hosted
    ) -> None:
        outcome = await asyncio.to_thread(work, hosted.name)  # it waits for the node's thread
        console.station.robot.note("YOU", "console", f"{title} {hosted.name}: {outcome.text}")
        console.look()
        console.tell(outcome)


class StartStop(_InNodes):
    id, key = "start_stop", "s"
    help = "Start or stop the selected node"

    async def run(self, console: Console) -> None:
        row, hosted = self._selected(console)
        if hosted.life != Life.UP:
            await self._do(console, "start", console.station.host.start_node, hosted)
            return
        goal = console.view.snapshot.goal
        if hosted.serves and goal is not None and goal.is_running:
            question = (
                f"The robot is on its way to shelf {goal.shelf}, and {row.name} may be the "
                "node that drives it and answers STOP. Stop the node?"
            )
            answer = await console.ask(Confirm("Stop a node", question, "Leave it", "Stop it"))
            if answer != "Stop it":
                return
        await self._do(console, "stop", console.station.host.stop_node, hosted)


class Copy(_InNodes):
    id, key = "copy_node", "plus"
    help = "Run another copy of the selected node"

    async def run(self, console: Console) -> None:
        row, hosted = self._selected(console)
        if hosted.serves:
            question = (
                f"{row.name} answers services. Any call, including STOP, may reach only one of the "
                "two. Run another copy?"
            )
            if await console.ask(Confirm("Another copy", question, "No", "Run it")) != "Run it":
                return
        await self._do(console, "copy", console.station.host.copy_node, hosted)


class Details(_InNodes):
    id, key = "details", "enter"
    help = "Show what is known about the selected node: after a crash, the traceback"

    def blocked(self, console: Console) -> str:
        return "" if console.main.nodes.selected else "no node is selected"

    def run(self, console: Console) -> None:
        row = console.main.nodes.selected
        assert row is not None
        console.open(ShowText(row.name, row.details(console.view.now, console.view.snapshot)))
