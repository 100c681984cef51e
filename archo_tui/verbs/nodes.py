"""The verbs for nodes: list, start, halt and copy them, and set their log level."""

from __future__ import annotations

from collections.abc import Callable

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.graph import LEVELS
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.ros_names import base_name
from archo_tui.station.station import Station
from archo_tui.verbs.base import ROBOT_TIMEOUT, Argument, Question, Values, Verb
from archo_tui.verbs.graph_names import full_name, nearest_node_hint
from archo_tui.words.goal import activity
from archo_tui.words.nodes import node_rows


class Nodes(Verb):
    id, title, tells = "nodes", "Nodes", True
    help = "List the nodes: the state of each, and which were started here"

    def is_ready(self, station: Station, values: Values) -> bool:
        return bool(station.robot.snapshot.nodes)

    async def run(self, station: Station, values: Values) -> Outcome:
        station.refresh()
        lines, rows = [], node_rows(station.view)
        for row in rows:
            _, word, _ = row.word()
            here = " (in this process)" if row.hosted else ""
            word = word or row.state.lifecycle or "up"
            lines.append(f"{row.name.lstrip('/')} {word}{here}")
        data = [
            {
                "name": row.name,
                "word": row.word()[1] or "up",
                "lifecycle": row.state.lifecycle or None,
                "here": row.hosted is not None,
                "rate": row.state.rate,
            }
            for row in rows
        ]
        return Report.of("\n".join(lines) or "no node is on the graph", data)


class _NodeVerb(Verb):
    """The base of the verbs that start, stop or copy one node of this process."""

    arguments = (Argument("node"),)
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
        return Question("Stop a node", text, "Leave it", "Stop it")


class DuplicateNode(_NodeVerb):
    id, title = "copy", "Copy"
    help = "Start another copy of a node that was started here"
    may_ask = starts = True

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


class LogLevel(Verb):
    id, title, tells = "log_level", "Log level", True
    help = f"Show or set the log level of a node: {', '.join(LEVELS).lower()}"
    arguments = (Argument("node"), Argument("level", optional=True))
    acts = True

    def acts_with(self, values: Values) -> bool:
        return "level" in values

    def tells_with(self, values: Values) -> bool:
        return not self.acts_with(values)

    def is_ready(self, station: Station, values: Values) -> bool:
        return self._name(station, values) in self._nodes(station) or station.age >= ROBOT_TIMEOUT

    async def prepare(self, station: Station, values: Values) -> Values:
        name, nodes = self._name(station, values), self._nodes(station)
        if name not in nodes:
            raise ArchoError(f"no node {name} is on the graph{nearest_node_hint(name, nodes)}")
        given = {"node": name}
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

    @staticmethod
    def _nodes(station: Station) -> list[str]:
        return [node.name for node in station.robot.snapshot.nodes]

    def _name(self, station: Station, values: Values) -> str:
        return full_name(station.robot.snapshot, values["node"], self._nodes(station))


def _served_names(hosted: Hosted) -> list[str]:
    return [base_name(name) for name in hosted.serves]


def _stop_service(station: Station) -> str:
    stop = station.robot.file.stop
    return "" if stop is None else base_name(stop.service)
