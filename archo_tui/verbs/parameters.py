"""The verbs for parameters: show, set, undo, save to a file and load from one."""

from __future__ import annotations

import os.path
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.base.paths import typed_path
from archo_tui.base.safe_text import safe
from archo_tui.robot.clients import current_requester
from archo_tui.robot.graph.parameter_values import parse, range_text
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.graph import NOT_REPORTED, Parameter
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station import save_load
from archo_tui.station.station import Station
from archo_tui.verbs import as_json
from archo_tui.verbs.names import find_node, full_name
from archo_tui.verbs.verb import (
    Argument,
    NotOnGraphError,
    NotPossible,
    Question,
    Values,
    Verb,
    is_settled,
)

CHANGE = "change"  # The key of `undo`'s value: the change to undo.
TOLD = "told"  # The key of `set`'s value: the node, if the name alone told it.
SAME = "All parameters already have the values in the file."
NOBODY = "no node has reported its parameters yet"


def _unreported_lines(snapshot: Snapshot) -> list[str]:
    return [f"{node.lstrip('/')} {why}" for node, why in sorted(snapshot.unreported.items())]


def _owners_and_names(station: Station, _: Sequence[str]) -> Iterable[str]:
    """Return the nodes, and the names that only one of them has."""
    known = station.robot.snapshot.parameters
    counts = Counter(parameter.name for parameter in known)
    return [*(p.node for p in known), *(name for name, count in counts.items() if count == 1)]


def _names(station: Station, words: Sequence[str]) -> Iterable[str]:
    """Return the names behind a node; behind a name, its values."""
    names = [parameter.name for parameter in _parameters_of(station, words[0])]
    return names or _values(station, ["", words[0]])


def _values(station: Station, words: Sequence[str]) -> Iterable[str]:
    """Return `true` and `false` for a boolean parameter, nothing for others."""
    kinds = [p.type for p in _parameters_of(station, words[0]) if p.name == words[1]]
    return ("true", "false") if kinds == ["bool"] else ()


def _parameters_of(station: Station, node: str) -> list[Parameter]:
    """Return the parameters of a node; of all nodes if it is ""."""
    known = station.robot.snapshot.parameters
    if not node:
        return [*known]
    name = full_name(station.robot.snapshot, node, {p.node for p in known})
    return [parameter for parameter in known if parameter.node == name]


class _ParameterVerb(Verb):
    """The base of the verbs that show or set one parameter, whose node the name alone may tell."""

    arguments: tuple[Argument, ...] = (
        Argument("node", completer=_owners_and_names, optional=True),
        Argument("name", completer=_names),
    )

    def values(self, words: Sequence[str]) -> Values:
        is_without_node = len(words) - ("--" in words) == len(self.arguments) - 1
        return super().values(["", *words] if is_without_node else words)

    def is_found(self, station: Station, values: Values) -> bool:
        return bool(values.get("node")) or is_settled(station)  # Others may have the name, too.

    def find_parameter(self, station: Station, values: Values) -> Parameter:
        """Return the parameter that the values name.

        Raises ArchoError, and NotPossible if its node has not reported its parameters.
        """
        snapshot, name = station.robot.snapshot, values["name"]
        of_node = _parameters_of(station, values.get("node", ""))
        found = [parameter for parameter in of_node if parameter.name == name]
        if len(found) == 1:
            return found[0]
        if not values.get("node"):
            raise self._unclear(name, of_node, [parameter.node for parameter in found])
        node = find_node(snapshot, values["node"], {p.node for p in snapshot.parameters})
        if node in snapshot.unreported:
            raise NotPossible(f"{node} {snapshot.unreported[node]}")
        near = nearest_hint(name, [parameter.name for parameter in of_node])
        raise ArchoError(f"{node} has no parameter {name}{near}")

    def _unclear(self, name: str, known: Iterable[Parameter], nodes: Sequence[str]) -> ArchoError:
        """Return the error for a name that no node has, or several."""
        if nodes:
            having = ", ".join(node.lstrip("/") for node in nodes)
            return ArchoError(f"{name} is in several nodes, so say in which: {having}")
        if any(name.lstrip("/") == parameter.node.lstrip("/") for parameter in known):
            return ArchoError(f"{name} is a node: needs {self.usage}")
        near = nearest_hint(name, {parameter.name for parameter in known})
        return NotOnGraphError(f"no node has a parameter {name}{near}")

    async def prepare(self, station: Station, values: Values) -> Values:
        return {**values, "parameter": self.find_parameter(station, values)}


class Get(_ParameterVerb):
    id, title, tells = "get", "Get a parameter", True
    help = "Show a parameter"

    async def run(self, station: Station, values: Values) -> Outcome:
        shown = _for_requester(values["parameter"])
        return Report.of(parameter_line(shown), as_json.parameter(shown))


class Set(_ParameterVerb):
    id, title, acts = "set", "Set a parameter", True
    help = "Set a parameter; quotes work as in a shell, and empty text is ''"
    arguments = (
        *_ParameterVerb.arguments,
        Argument("value", rest=True, completer=_values),
    )

    async def prepare(self, station: Station, values: Values) -> Values:
        parameter = self.find_parameter(station, values)
        try:
            value = parse(parameter, values["value"])
        except ValueError as error:
            node = parameter.node.lstrip("/")
            raise ArchoError(f"{node} {parameter.name}: {error}") from None
        told = "" if values.get("node") else f"{parameter.node.lstrip('/')} "
        return {**values, "node": parameter.node, "value": value, TOLD: told}

    async def run(self, station: Station, values: Values) -> Outcome:
        parameter = self.find_parameter(station, values)
        changed = {parameter.name: values["value"]}
        outcome = await station.set_parameters(parameter.node, changed)
        return outcome._replace(text=f"{values.get(TOLD, '')}{outcome.text}")


class Undo(Verb):
    id, title = "undo", "Undo"
    help = "Undo your last change of a parameter"
    acts = may_ask = True

    def disabled_reason(self, station: Station) -> str:
        return station.edits.disabled_reason(station.robot.snapshot)

    def is_answered(self, station: Station) -> bool:
        return not station.edits.is_changing

    def question(self, station: Station, values: Values) -> Question | None:
        edits = station.edits
        others = edits.changed_since(station.robot.snapshot)
        if edits.last is None or not others:
            return None
        text = " ".join(
            f"{name} has since changed to {text_of(value)}. "
            f"Restore {text_of(edits.last.before[name])}?"
            for name, value in others.items()
        )
        return Question("Undo", text, "Leave it", "Restore")

    async def prepare(self, station: Station, values: Values) -> Values:
        return {CHANGE: station.edits.last}

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.undo(values[CHANGE])


class Params(Verb):
    id, title, tells, lists = "params", "Parameters", True, True
    help = "List the parameters"

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot = station.robot.snapshot
        shown = [_for_requester(found) for found in snapshot.parameters]
        lines = [*map(parameter_line, shown), *_unreported_lines(snapshot)]
        return Report.of("\n".join(lines), [*map(as_json.parameter, shown)])


def _for_requester(parameter: Parameter) -> Parameter:
    """Return the parameter, for an assistant with a secret value masked."""
    return parameter.masked if current_requester().is_assistant else parameter


_LONGEST = 500  # Characters of a value in a line; --json has all of them.


def parameter_line(parameter: Parameter) -> str:
    """Return a line like `motor_controller max_speed is 0.5, was 0.8 at the start, double`."""
    value = text_of(parameter.value)
    if len(value) > _LONGEST:
        value = f"{value[:_LONGEST]} ... ({len(value)} characters)"
    parts = [f"{parameter.node.lstrip('/')} {parameter.name} is {value}"]
    if parameter.is_changed:
        parts.append(f"was {text_of(parameter.initial)} at the start")
    parts.append(parameter.type)
    allowed = range_text(parameter)
    if allowed:
        parts.append(allowed if parameter.read_only else f"allowed {allowed}")
    return safe(", ".join(parts))  # A name may be any text, too.


class _FileVerb(Verb):
    """The base of `save` and `load`, disabled until a node has reported its parameters."""

    arguments = (Argument("file"),)
    may_ask = lists = True

    def disabled_reason(self, station: Station) -> str:
        return "" if station.robot.snapshot.parameters else NOBODY

    def path(self, values: Values) -> Path:
        return typed_path(values["file"])


class Save(_FileVerb):
    id, title = "save", "Save parameters"
    help = "Save all parameters to a ROS parameter file"

    async def prepare(self, station: Station, values: Values) -> Values:
        path = self.path(values)
        return {"file": path, "exists": await in_daemon(os.path.exists, path)}

    def question(self, station: Station, values: Values) -> Question | None:
        if not values["exists"]:
            return None
        text = f"{values['file']} already exists. Overwrite it?"
        return Question("Save parameters", text, "Keep it", "Overwrite")

    async def run(self, station: Station, values: Values) -> Outcome:
        snapshot = station.robot.snapshot
        text, left_out = save_load.dump(snapshot.parameters)
        try:
            await in_daemon(save_load.write_atomically, values["file"], text)
        except ArchoError as error:
            return Outcome(Code.REFUSED, str(error))
        said = f"saved to {values['file']}"
        is_whole = NOT_REPORTED not in snapshot.unreported.values()
        code = Code.DONE if is_whole else Code.REFUSED
        record = AuditRecord(self.id, {"file": str(values["file"])}, code)
        station.robot.note("YOU", "console", f"save parameters: {said}", audit_record=record)
        reasons = [*_unreported_lines(snapshot)]
        reasons += [f"a parameter file cannot hold it: {what}" for what in left_out]
        not_saved = [f"not saved, {reason}" for reason in reasons]
        for line in not_saved:
            station.robot.note("WARN", "console", line)
        return Outcome(code, "; ".join([said, *not_saved]))


class Load(_FileVerb):
    id, title = "load", "Load parameters"
    help = "Load a ROS parameter file; shows the changes first"
    acts = tells = True

    async def prepare(self, station: Station, values: Values) -> Values:
        path, snapshot = self.path(values), station.robot.snapshot
        plan = await in_daemon(save_load.plan_load, path, snapshot.parameters, snapshot.unreported)
        return {"file": path, "plan": plan}

    def question(self, station: Station, values: Values) -> Question | None:
        """Return the question, whose text lists the changes; without any, `go` is ""."""
        plan = values["plan"]
        count = len(plan.changes)
        go = f"Change {count} parameter{'' if count == 1 else 's'}"
        go = go if count and not plan.problems else ""
        return Question("Load parameters", "\n".join(preview(values["file"], plan)), "Cancel", go)

    async def run(self, station: Station, values: Values) -> Outcome:
        plan = values["plan"]
        if plan.problems:
            return Outcome(Code.MISUSE, f"nothing was changed: {'; '.join(plan.problems)}")
        by_node: dict[str, dict[str, Any]] = {}
        for parameter, value in plan.changes:
            by_node.setdefault(parameter.node, {})[parameter.name] = value
        outcomes = [await station.set_parameters(*changes) for changes in by_node.items()]
        refused = [outcome for outcome in outcomes if not outcome.ok]
        if refused:
            return Outcome(refused[0].code, "; ".join(outcome.text for outcome in refused))
        said = f"{len(plan.changes)} changed" if plan.changes else SAME
        if not plan.left_out:
            return Outcome(Code.DONE, said)
        said = said if plan.changes else "nothing was changed"
        return Outcome(Code.REFUSED, "\n".join((said, *_left_out(plan))))


def preview(path: Path, plan: save_load.LoadPlan) -> Sequence[str]:
    """Return the lines that tell what loading a file would change, or why it cannot be loaded."""
    lines = [str(path), ""]
    if plan.problems:
        return [*lines, "Nothing was changed, because of:", *plan.problems]
    changes = [
        safe(f"{p.node.lstrip('/')} {p.name}: {text_of(p.value)}, would be {text_of(value)}")
        for p, value in plan.changes
    ]
    same = [] if plan.left_out else [SAME]
    return [*lines, *(changes or same), *_left_out(plan)]


def _left_out(plan: save_load.LoadPlan) -> list[str]:
    return [f"left out: {line}" for line in plan.left_out]
