"""The verb for the state of a managed node."""

from __future__ import annotations

from archo_tui.errors import ArchoError
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.graph import ACTION, SERVICE, NodeState
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.station import Station
from archo_tui.verbs.base import ROBOT_TIMEOUT, Argument, Question, Values, Verb
from archo_tui.verbs.graph_names import full_name, nearest_node_hint
from archo_tui.words.goal import activity

_FINAL = "finalized"  # The state from which there is no transition.


class Lifecycle(Verb):
    """The verb `lifecycle`: show a managed node's state and its transitions, or request one.

    A question comes before a shutdown, and before any transition of a node that serves STOP or the
    running goal.
    """

    id, title, tells = "lifecycle", "Lifecycle", True
    help = "Show the state of a managed node, or change it: configure, activate, ..."
    arguments = (Argument("node"), Argument("transition", optional=True))
    acts = may_ask = True

    def acts_with(self, values: Values) -> bool:
        return "transition" in values

    def tells_with(self, values: Values) -> bool:
        return not self.acts_with(values)

    def is_ready(self, station: Station, values: Values) -> bool:
        node = _managed(station.robot.snapshot).get(self._name(station, values))
        return node is not None or station.age >= ROBOT_TIMEOUT

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot = station.robot.snapshot
        name, managed = self._name(station, values), _managed(snapshot)
        if name not in managed:
            is_there = name in {node.name for node in snapshot.nodes}
            why = f"{name} is not a managed node" if is_there else f"no node {name} is on the graph"
            raise ArchoError(f"{why}{nearest_node_hint(name, managed)}")
        given = {"node": name}
        if "transition" in values:
            given["transition"] = values["transition"].lower()
        return given

    def question(self, station: Station, values: Values) -> Question | None:
        if "transition" not in values:
            return None
        node, transition = values["node"], values["transition"]
        reasons = list(_objections(station.robot.snapshot, node))
        if transition == "shutdown":
            reasons.append("a node that was shut down must be started anew")
        if not reasons:
            return None
        text = f"{'; '.join(reasons)}. {transition.capitalize()} {node}?"
        title = f"{transition.capitalize()} a node"
        return Question(title, text[0].upper() + text[1:], "Leave it", transition.capitalize())

    async def run(self, station: Station, values: Values) -> Outcome:
        node, outcome = values["node"], await self._run(station, values)
        managed = _managed(station.robot.snapshot).get(node)
        data = {"node": node, "state": None if managed is None else managed.lifecycle}
        return Report.of(outcome.text, data) if outcome.ok else outcome

    async def _run(self, station: Station, values: Values) -> Outcome:
        node = values["node"]
        if "transition" in values:
            return await station.robot.change_lifecycle(node, values["transition"])
        managed = _managed(station.robot.snapshot)
        if node not in managed:
            return Outcome(Code.NOT_OFFERED, f"{node} has left")
        state = managed[node].lifecycle
        possible = ", ".join(await station.robot.lifecycle_transitions(node))
        if not possible and state != _FINAL:
            return Outcome(Code.TIMEOUT, f"no answer from {node.lstrip('/')}; shown is {state}")
        can = f": it can {possible}" if possible else ""
        return Outcome(Code.DONE, f"{node.lstrip('/')} is {state}{can}")

    def _name(self, station: Station, values: Values) -> str:
        snapshot = station.robot.snapshot
        return full_name(snapshot, values["node"], [node.name for node in snapshot.nodes])


def _managed(snapshot: Snapshot) -> dict[str, NodeState]:
    return {node.name: node for node in snapshot.nodes if node.lifecycle}


def _objections(snapshot: Snapshot, node: str) -> list[str]:
    """Return the reasons why a transition of a node needs a question.

    Where the graph has a service or action but not its node, any node may be the one.
    """
    reasons, stop, goal = [], snapshot.file.stop, snapshot.running_goal
    if stop is not None and _may_serve(snapshot, node, SERVICE, snapshot.full(stop.service)):
        reasons.append(f"{node} serves STOP ({stop.service})")
    if goal is not None and _may_serve(snapshot, node, ACTION, snapshot.full(goal.kind.action)):
        reasons.append(f"the robot is {activity(goal)}, and {node} serves {goal.kind.action}")
    return reasons


def _may_serve(snapshot: Snapshot, node: str, kind: str, name: str) -> bool:
    found = [r for r in snapshot.resources if (r.kind, r.name) == (kind, name)]
    nodes = [server for resource in found for server in resource.nodes]
    return node in nodes or (bool(found) and not nodes)
