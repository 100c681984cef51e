"""The verbs for nodes: list, start, halt and copy them, set log level and lifecycle state."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.graph import ACTION, LEVELS, SERVICE, NodeState
from archo_tui.robot.state.snapshot import Hosted, Snapshot
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.robot_file.model import RobotFile
from archo_tui.ros.names import base_name
from archo_tui.station.station import Station
from archo_tui.text.goal import activity
from archo_tui.text.nodes import node_rows
from archo_tui.verbs.names import find_node, full_name, nearest_node_hint, node_names
from archo_tui.verbs.verb import Argument, Forms, NotOnGraphError, Question, Values, Verb


class Nodes(Verb):
    id, title, tells, lists = "nodes", "Nodes", True, True
    help = "List the nodes: the state of each, and which were started here"

    async def run(self, station: Station, values: Values) -> Outcome:
        station.refresh()
        lines, data = [], []
        for row in node_rows(station.view):
            _, word, _ = row.word()
            lifecycle, is_here = row.state.lifecycle, row.hosted is not None
            here = " (in this process)" if is_here else ""
            lines.append(f"{row.name.lstrip('/')} {word or lifecycle or 'up'}{here}")
            told = {"name": row.name, "word": word or "up", "lifecycle": lifecycle or None}
            data.append({**told, "here": is_here, "rate": row.state.rate})
        return Report.of("\n".join(lines) or "no node is on the graph", data)


class _NodeVerb(Verb):
    """The base of the verbs that start, stop or copy one node of this process."""

    arguments = (
        Argument("node", completer=lambda station, _: [n.name for n in station.host.states()]),
    )
    acts = True
    starts = False  # True if one more node is on the graph afterwards.

    async def prepare(self, station: Station, values: Values) -> Values:
        return {"node": self.find_node(station, values["node"]).name}

    def find_node(self, station: Station, name: str) -> Hosted:
        """Return the node of this process with a name; ArchoError if there is none."""
        hosted = {node.name: node for node in station.host.states()}
        full = full_name(station.robot.snapshot, name, hosted)
        if full in hosted:
            return hosted[full]
        raise ArchoError(f"{name} does not run in this process{nearest_node_hint(full, hosted)}")

    async def run(self, station: Station, values: Values) -> Outcome:
        name: str = values["node"]
        if station.robot.stops.gate().is_shut:
            outcome = Outcome(Code.CANCELLED, NOT_SENT)
        else:
            outcome = await in_daemon(self.work(station), name)  # It waits for the node's thread.
        if self.starts:
            station.node_started()
        record = AuditRecord(self.id, {"node": name}, outcome.code)
        text = f"{self.title.lower()} {name}: {outcome.text}"
        station.robot.note("YOU", "console", text, audit_record=record)
        station.refresh()
        return outcome

    def work(self, station: Station) -> Callable[[str], Outcome]:
        """Return the function that `run` calls with the node's full name, on a daemon thread."""
        raise NotImplementedError


class StartNode(_NodeVerb):
    id, title = "start", "Start"
    help = "Restart a node that was started here and has stopped or crashed"
    starts = True

    def work(self, station: Station) -> Callable[[str], Outcome]:
        return station.host.start_node


class StopNode(_NodeVerb):
    id, title = "halt", "Stop"
    help = "Stop a node that was started here; asks first if the robot needs it now"
    may_ask = True

    def work(self, station: Station) -> Callable[[str], Outcome]:
        return station.host.stop_node

    def question(self, station: Station, values: Values) -> Question | None:
        goal, hosted = station.running_goal, self.find_node(station, values["node"])
        if goal is None or not hosted.life.is_running:
            return None
        grave = (base_name(goal.kind.action), _stop_service(station))
        needed = " and ".join(name for name in _served_names(hosted) if name in grave)
        if not needed:
            return None
        text = f"The robot is {activity(goal)}, and {hosted.name} serves {needed}. Stop the node?"
        return Question("Stop a node", text, "Leave it", "Stop it", goal)


class DuplicateNode(_NodeVerb):
    """The verb of the key that starts another copy of a node; it has no word."""

    id, title = "copy", "Copy"
    help = "Start another copy of a node that was started here"
    may_ask = starts = True

    @classmethod
    def of_robot(cls, _robot: RobotFile, _forms: Forms) -> Iterator[Verb]:
        return iter(())

    def work(self, station: Station) -> Callable[[str], Outcome]:
        return station.host.copy_node

    def question(self, station: Station, values: Values) -> Question | None:
        hosted = self.find_node(station, values["node"])
        if not hosted.serves:
            return None
        served = _served_names(hosted)
        stop = " STOP must then be confirmed by both." if _stop_service(station) in served else ""
        text = (
            f"{hosted.name} serves {', '.join(served)}: a call reaches both, and both act.{stop} "
            "Run another copy?"
        )
        return Question("Another copy", text, "No", "Run it")


class _NodeSetting(Verb):
    """The base of the verbs that show something of any node, or with a second word change it."""

    acts = tells = True

    def acts_with(self, values: Values) -> bool:
        return self.arguments[1].name in values

    def tells_with(self, values: Values) -> bool:
        return not self.acts_with(values)


class LogLevel(_NodeSetting):
    id, title = "log_level", "Log level"
    help = f"Show or set the log level of a node: {', '.join(LEVELS).lower()}"
    arguments = (
        Argument("node", completer=node_names),
        Argument("level", optional=True, completer=lambda *_: [each.lower() for each in LEVELS]),
    )

    async def prepare(self, station: Station, values: Values) -> Values:
        given = {"node": find_node(station.robot.snapshot, values["node"])}
        if "level" in values:
            given["level"] = values["level"].upper()
            if given["level"] not in LEVELS:
                words = ", ".join(LEVELS).lower()
                raise ArchoError(f"{values['level']} is not a log level: one of {words}")
        return given

    async def run(self, station: Station, values: Values) -> Outcome:
        if "level" in values:
            return await station.robot.set_log_level(values["node"], values["level"])
        return await station.robot.log_level(values["node"])


def _served_names(hosted: Hosted) -> list[str]:
    return [base_name(name) for name in hosted.serves]


def _stop_service(station: Station) -> str:
    stop = station.robot.file.stop
    return "" if stop is None else base_name(stop.service)


_FINAL = "finalized"  # The state from which there is no transition.
_TRANSITIONS = "configure", "activate", "deactivate", "cleanup", "shutdown"


class Lifecycle(_NodeSetting):
    """The verb `lifecycle`: show a managed node's state and its transitions, or request one.

    A question comes before a shutdown, and before any transition of a node that serves STOP or the
    running goal.
    """

    id, title = "lifecycle", "Lifecycle"
    help = "Show the state of a managed node, or change it: configure, activate, ..."
    arguments = (
        Argument("node", completer=lambda station, _: _managed(station.robot.snapshot)),
        Argument("transition", optional=True, completer=lambda *_: _TRANSITIONS),
    )
    may_ask = True

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot = station.robot.snapshot
        name, managed = find_node(snapshot, values["node"]), _managed(snapshot)
        if name not in managed:  # Its services may come.
            near = nearest_node_hint(name, managed)
            raise NotOnGraphError(f"{name} is not a managed node{near}")
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
        node = values["node"]
        if "transition" in values:
            outcome = await station.robot.change_lifecycle(node, values["transition"])
        elif node not in _managed(station.robot.snapshot):
            return Outcome(Code.NOT_OFFERED, f"{node} has left")
        else:
            state = _managed(station.robot.snapshot)[node].lifecycle
            possible = ", ".join(await station.robot.lifecycle_transitions(node))
            if not possible and state != _FINAL:
                return Outcome(Code.TIMEOUT, f"no answer from {node.lstrip('/')}; shown is {state}")
            can = f": it can {possible}" if possible else ""
            outcome = Outcome(Code.DONE, f"{node.lstrip('/')} is {state}{can}")
        managed = _managed(station.robot.snapshot).get(node)
        data = {"node": node, "state": None if managed is None else managed.lifecycle}
        return Report.of(outcome.text, data) if outcome.ok else outcome


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
