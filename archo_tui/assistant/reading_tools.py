"""The tools that only read: state, events, the last hour, parameters, topics, types."""

from __future__ import annotations

import re
import time
from typing import Any

from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.sanitize import MAX_ITEMS
from archo_tui.assistant.tool import Tool
from archo_tui.assistant.tool_answer import ToolAnswer, failure, robot_part_of

LEVELS = ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")
MAX_EVENTS = 50  # The newest, in one answer.
_SEARCHED_EVENTS = 500  # Requested if only those of a level are wanted.
_SPANS = (1, 10, 60)  # In min; the console tells the values at these ages.
_VALUE = re.compile(r"(?:now|(\d+) min ago) (-?\d+\.\d+)$")


class _VerbTool(Tool):
    """The base of tools that run one of the console's reading verbs, and sum up its result."""

    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        result = await connection.request(words=self.words(given))
        if result["code"] != "done":
            return failure(
                result["code"], f"{self.name}: this was not answered.", robot_part_of(result)
            )
        summary, data = self.summarize(result, given)
        return ToolAnswer("done", summary, data)

    def words(self, given: dict[str, Any]) -> list[str]:
        """Return the verb and its arguments as for a shell; by default the tool's name alone."""
        return [self.name]

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        """Return a summary in our own words, and what the robot said, for a successful result."""
        raise NotImplementedError


class StatusTool(_VerbTool):
    """The tool for the state of the robot: battery, motion, goal, queue and alarms."""

    name, title = "status", "State of the robot"
    description = (
        "The robot's state: battery, motion, the last goal, the queue and the alarms. Each reading "
        "has `age`, in s since it was heard (null: never), and `source`: measured by the robot, or "
        "commanded by somebody. An old reading says nothing about now. A goal has arrived only "
        "when its `code` is `arrived`."
    )

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        return "The state, as the console knows it now.", result.get("data")


class EventsTool(_VerbTool):
    """The tool for the newest events, 50 at most and the newest last, from a level on."""

    name, title = "events", "What happened"
    description = (
        f"The newest {MAX_EVENTS} events: what nodes logged, what was done and by whom. `age` is "
        "in s. Log lines are written by programs and people that nobody here has checked."
    )
    schema = schema_of(
        {
            "level": {
                "type": "string",
                "enum": list(LEVELS),
                "description": "leave out events below this level",
            }
        }
    )

    def words(self, given: dict[str, Any]) -> list[str]:
        return ["events", str(_SEARCHED_EVENTS if "level" in given else MAX_EVENTS)]

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        now = time.time()
        wanted = LEVELS[LEVELS.index(given.get("level", LEVELS[0])) :]
        every = [event for event in _objects(result) if event.get("level") in wanted]
        events = [
            {
                "age": _age(event.get("time"), now),
                **{name: value for name, value in event.items() if name != "time"},
            }
            for event in every[-MAX_EVENTS:]
        ]
        older = len(every) - len(events)
        cut = f"; {older} older ones are left out" if older else ""
        return f"{len(events)} events, the newest last{cut}.", {"events": events}


class HistoryTool(_VerbTool):
    """The tool for measured values, now and up to 60 min ago, and how the last goals ended."""

    name, title = "history", "The last hour"
    description = (
        "Charge, speed and the way left now and some minutes ago, as they were measured, and how "
        "the last goals ended. `age` is in s; a value of null was not heard at that time."
    )
    schema = schema_of(
        {
            "minutes": {
                "type": "integer",
                "enum": list(_SPANS),
                "description": "how far to look back; 60 unless told",
            }
        }
    )

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        minutes = given.get("minutes", _SPANS[-1])
        measured, ends = {}, []
        for text in str(result.get("text", "")).splitlines():
            name, _, rest = text.partition(": ")
            found = [_VALUE.match(part) for part in rest.split(", ")]
            known = {int(match[1] or 0): float(match[2]) for match in found if match is not None}
            if None not in found:
                ages = (age for age in (0, *_SPANS) if age <= minutes)
                measured[name] = [{"age": 60.0 * age, "value": known.get(age)} for age in ages]
            else:
                ends.append(text)
        data = {"source": "measured", "values": measured, "goals": ends}
        return f"The last {minutes} min, and how the last goals ended.", data


class ParametersTool(_VerbTool):
    """The tool for the parameters of all nodes, of one node, or one parameter of a node."""

    name, title = "parameters", "Parameters"
    description = (
        "The parameters of the robot's nodes with their ranges, as each node last reported them; "
        f"at most {MAX_ITEMS}. Name a node to see its own, or a node and a parameter. They are "
        "settings that somebody commanded, not measurements. There is no tool that sets one."
    )
    schema = schema_of(
        {
            "node": {"type": "string", "description": "a node's name, as motor_controller"},
            "name": {"type": "string", "description": "a parameter's name; takes a node too"},
        }
    )

    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        if "name" in given and "node" not in given:
            return failure("misuse", "name takes a node too: which node has this parameter?")
        return await super().call(connection, given)

    def words(self, given: dict[str, Any]) -> list[str]:
        return ["get", given["node"], given["name"]] if "name" in given else ["params"]

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        data = result.get("data")
        found = [data] if isinstance(data, dict) else _objects(result)
        if "name" not in given and "node" in given:
            wanted = given["node"].strip("/")
            found = [
                parameter
                for parameter in found
                if str(parameter.get("node", "")).strip("/") == wanted
            ]
        data = {
            "age": None,  # The console does not tell when a node reported them.
            "source": "commanded",
            "parameters": found,
        }
        if "name" not in given:  # Behind a line for each parameter.
            lines = str(result.get("text", "")).splitlines()
            data["not_reported"] = lines[len(_objects(result)) :]
        return f"{len(found)} parameters, as their nodes reported them.", data


class InterfaceTool(_VerbTool):
    """The tool for the definition of a message, service or action type, line by line."""

    name, title = "interface", "Definition of a type"
    description = (
        "The definition of a message, service or action type as its file has it: fields, constants "
        "and comments, nested types indented. The units of values often stand in the comments."
    )
    schema = schema_of(
        {
            "type": {
                "type": "string",
                "description": "as std_msgs/msg/String, or a Name that is on the graph once",
            }
        },
        required=("type",),
    )

    def words(self, given: dict[str, Any]) -> list[str]:
        return ["interface", given["type"]]

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        data = result.get("data")
        found = data if isinstance(data, dict) else {}
        lines = str(found.get("definition", "")).splitlines()
        return "The definition, line by line.", {"type": found.get("type"), "lines": lines}


class EchoTool(_VerbTool):
    """The tool for the last message of a topic, or one field of it."""

    name, title = "echo", "Last message of a topic"
    description = (
        "The last message of any topic on the graph, or the one that comes within 5 s: field by "
        "field, without units (see `interface`). Its `age` is not known: a message that is kept "
        "may be old. Long arrays are described by their type, least and greatest value."
    )
    schema = schema_of(
        {
            "topic": {"type": "string", "description": "its name, as /battery_level"},
            "field": {
                "type": "string",
                "description": "only this field, as pose.position.x; the whole message unless told",
            },
        },
        required=("topic",),
    )

    def words(self, given: dict[str, Any]) -> list[str]:
        return ["echo", given["topic"], *([given["field"]] if "field" in given else [])]

    def summarize(self, result: dict[str, Any], given: dict[str, Any]) -> tuple[str, Any]:
        message = result.get("data")
        data = {"age": None, "message": message}
        if message is None:  # It is too large for data.
            data["message"] = str(result.get("text", "")).splitlines()
        return "The last message that was received.", data


def _objects(result: dict[str, Any]) -> list[dict[str, Any]]:
    data = result.get("data")
    return [item for item in data if isinstance(item, dict)] if isinstance(data, list) else []


def _age(then: Any, now: float) -> float | None:
    """Return how long ago a Unix time was, in seconds; None if it is none."""
    is_time = isinstance(then, (int, float)) and 0 <= then < 1e12
    return round(max(now - then, 0.0), 1) if is_time else None
