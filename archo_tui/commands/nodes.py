"""Commands of the nodes' panel."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING

from archo_tui.commands.base import IN_PANEL, NODES, Command
from archo_tui.robot.state import Hosted, Life, Outcome
from archo_tui.screens.confirm import Confirm
from archo_tui.screens.text import ShowText

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp


class _InNodes(Command):
    where, panel = IN_PANEL, NODES

    def blocked(self, app: ArchoApp) -> str:
        row = app.main.nodes.selected
        if row is None:
            return "no node is selected"
        return "" if row.hosted else f"{row.name} does not run in this process"

    async def _do(
        self, app: ArchoApp, title: str, work: Callable[[str], Outcome], hosted: Hosted
    ) -> None:
        outcome = await asyncio.to_thread(work, hosted.name)  # it waits for the node's thread
        app.robot.note("YOU", "console", f"{title} {hosted.name}: {outcome.text}")
        app.show()
        app.tell(outcome)


class StartStop(_InNodes):
    """Start or stop the selected node."""

    id, key = "start_stop", "s"

    async def run(self, app: ArchoApp) -> None:
        row = app.main.nodes.selected
        assert row is not None
        assert row.hosted is not None
        if row.hosted.life != Life.UP:
            await self._do(app, "start", app.host.start_node, row.hosted)
            return
        goal = app.view.snapshot.goal
        if row.hosted.serves and goal is not None and goal.is_running:
            question = (
                f"The robot is on its way to shelf {goal.shelf}, and {row.name} may be what drives "
                "it and what hears STOP. Stop the node?"
            )
            if await app.ask(Confirm("Stop a node", question, "Leave it", "Stop it")) != "Stop it":
                return
        await self._do(app, "stop", app.host.stop_node, row.hosted)


class Copy(_InNodes):
    """Run one more of the selected node."""

    id, key = "copy_node", "plus"

    async def run(self, app: ArchoApp) -> None:
        row = app.main.nodes.selected
        assert row is not None
        assert row.hosted is not None
        if row.hosted.serves:
            question = (
                f"{row.name} answers services. With two of them each call, STOP too, may reach "
                "only one. Run one more?"
            )
            if await app.ask(Confirm("One more", question, "No", "One more")) != "One more":
                return
        await self._do(app, "copy", app.host.copy_node, row.hosted)


class Details(_InNodes):
    """Show what is known of the selected node: after a crash, the traceback."""

    id, key = "details", "enter"

    def blocked(self, app: ArchoApp) -> str:
        return "" if app.main.nodes.selected else "no node is selected"

    def run(self, app: ArchoApp) -> None:
        row = app.main.nodes.selected
        assert row is not None
        app.push_screen(ShowText(row.name, row.details(app.view.now, app.view.snapshot)))
