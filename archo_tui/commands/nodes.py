"""Commands of the nodes' panel."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from archo_tui.commands.base import IN_PANEL, NODES, Command, Console, Work
from archo_tui.daemon_threads import in_daemon
from archo_tui.goal_text import way
from archo_tui.robot.state import Hosted, Life, Outcome
from archo_tui.robot.stops import NOT_SENT
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
        if console.station.robot.stops.gate().is_shut:
            outcome = Outcome(False, NOT_SENT)
        else:
            outcome = await in_daemon(work, hosted.name)  # it waits for the node's thread
        console.station.robot.note("YOU", "console", f"{title} {hosted.name}: {outcome.text}")
        console.look()
        console.tell(outcome)


def _short(hosted: Hosted) -> list[str]:
    """What a node serves, without the namespace."""
    return [_last(name) for name in hosted.serves]


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def _stop(console: Console) -> str:
    """The service of the robot's STOP, without the namespace."""
    stop = console.view.snapshot.robot.stop
    return "" if stop is None else _last(stop.service)


class StartStop(_InNodes):
    id, key = "start_stop", "s"
    help = "Start or stop the selected node"
    once = True

    def run(self, console: Console) -> Work | None:
        row, hosted = self._selected(console)
        host, goal = console.station.host, console.view.snapshot.running_goal
        if hosted.life != Life.UP:
            return self._do(console, "start", host.start_node, hosted)
        stop = partial(self._do, console, "stop", host.stop_node, hosted)
        if goal is None:
            return stop()
        grave = (_last(goal.kind.action), _stop(console))
        needed = " and ".join(name for name in _short(hosted) if name in grave)
        if not needed:
            return stop()
        question = f"The robot is {way(goal)}, and {row.name} serves {needed}. Stop the node?"
        console.confirm("Stop a node", question, "Leave it", {"Stop it": stop})
        return None


class Copy(_InNodes):
    id, key = "copy_node", "plus"
    help = "Run another copy of the selected node"
    once = True

    def run(self, console: Console) -> Work | None:
        row, hosted = self._selected(console)
        copy = partial(self._do, console, "copy", console.station.host.copy_node, hosted)
        if not hosted.serves:
            return copy()
        names = ", ".join(_short(hosted))
        stop = " STOP must then be confirmed by both." if _stop(console) in _short(hosted) else ""
        question = (
            f"{row.name} serves {names}: a call reaches both, and both act.{stop} Run another copy?"
        )
        console.confirm("Another copy", question, "No", {"Run it": copy})
        return None


class Details(_InNodes):
    id, key = "details", "enter"
    help = "Show what is known about the selected node: after a crash, the traceback"

    def blocked(self, console: Console) -> str:
        return "" if console.main.nodes.selected else "no node is selected"

    def run(self, console: Console) -> None:
        row = console.main.nodes.selected
        assert row is not None
        console.open(ShowText(row.name, row.details(console.view.now, console.view.snapshot)))
