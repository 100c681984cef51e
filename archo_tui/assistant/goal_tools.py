"""The tools that `--allow goals` adds. They ask for goals; a person at the console decides."""

from __future__ import annotations

import asyncio
import json
import time
from typing import Any

from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.connection import ANSWER_TIMEOUT, ConsoleConnection
from archo_tui.assistant.sanitize import sanitize
from archo_tui.assistant.tool import READS, Hints, Tool
from archo_tui.assistant.tool_answer import ToolAnswer, failure, robot_part_of
from archo_tui.client.connection import Unreached

MAX_WAIT = 50.0  # Seconds; clients give up a call after a minute.
_SLICE = 1.0  # Seconds of one request to wait, so that other calls get a turn.
_MIN_SLICE = 0.1  # Seconds.
_LIST_TIMEOUT = 2.0  # Seconds in which clients want a list of tools.
_MAX_SCHEMAS = 16 * 1024  # Characters of all goals in the list of tools.
_KIND = {"type": "string", "description": "which kind of goal, as the robot offers it"}
_VALUES = {
    "type": "object",
    "description": 'the values of the goal by name, as {"shelf_number": 12}',
}
# Codes that no request without a number has.
_NO_REQUEST = ("asked", "done", "accepted", "arrived")
_ENDS = {
    "arrived": "The goal arrived: the robot's own result says so.",
    "denied": "A person said no, and this request moved nothing. Ask them what they want instead.",
    "expired": "Nobody answered in time: this request moved nothing. `go` makes another.",
    "void": "The request became void and moved nothing; `said` tells why. `go` makes another.",
    "aborted": "The goal ended without arriving.",
    "cancelled": "The goal was cancelled: it did not arrive.",
    "misuse": "Nothing is known of such a request: `said` tells why.",
    "ran_out": "Not over yet; `said` tells whether a person is still to answer or the goal runs. "
    "Call `wait` again.",
}


class GoTool(Tool):
    """The tool that asks a person for a goal, and returns without waiting for the decision."""

    name, title = "go", "Ask for a goal"
    description = (
        "Ask a person at the console to let the robot drive to a goal. Answers at once with the "
        "number of the request; NOTHING MOVES until a person allows it, with exactly these values, "
        "within a minute. Then `wait` tells what became of it. Never report that the robot has "
        "moved or arrived before `wait` says `arrived`."
    )
    # A robot that drives changes a world of which this program knows little.
    hints = Hints(destroys=True, is_idempotent=False, is_open=True)
    schema = schema_of({"kind": _KIND, "values": _VALUES}, ("kind", "values"))

    async def offered_schema(self, connection: ConsoleConnection) -> dict[str, Any]:
        """Return the schema with the robot's goals, unless the list is late or too large."""
        try:
            goals = await asyncio.wait_for(_goals(connection), _LIST_TIMEOUT)
        except (Unreached, asyncio.TimeoutError):
            goals = []
        if not goals or len(json.dumps(goals)) > _MAX_SCHEMAS:
            return self.schema
        kinds = [goal["kind"] for goal in goals]
        forms = [{**goal["schema"], "title": f"{goal['kind']}: {goal['title']}"} for goal in goals]
        values = {**_VALUES, "anyOf": forms} if len(forms) > 1 else {**_VALUES, **forms[0]}
        return schema_of({"kind": {**_KIND, "enum": kinds}, "values": values}, ("kind", "values"))

    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        result = await connection.request(ask={"kind": given["kind"], "values": given["values"]})
        code, data = result["code"], result.get("data")
        request = data.get("request") if isinstance(data, dict) else None
        if code == "asked" and isinstance(request, int):
            summary = (
                f"Request {request} waits for a person at the console. Nothing moves yet. "
                f"Call `wait` with request {request}."
            )
            return ToolAnswer(code, summary, robot_part_of(result))
        if code == "misuse":
            data = {**robot_part_of(result), "goals": await _goals(connection)}
            summary = "Nothing was asked: this kind of goal or its values cannot be meant."
            return failure(code, f"{summary} `goals` are those that there are.", data)
        if code in _NO_REQUEST:
            summary = "This answer is not understood: look at `status` before anything else."
            return failure("not_confirmed", summary, robot_part_of(result))
        return failure(
            code,
            "Nothing was asked, and nothing moves: `said` tells why.",
            robot_part_of(result),
        )


class WaitTool(Tool):
    """The tool that waits, up to 50 s, for the end of a request without a goal, or of its goal.

    The console is asked again each second, so that other calls get a turn.
    """

    name, title = "wait", "Wait for a request"
    description = (
        "Wait until the request of a `go` is denied, expires or becomes void, or until its goal "
        "ends, and tell which. `arrived` alone means that the robot is there. `ran_out` means that "
        "it is not over: call it again."
    )
    hints = READS
    schema = schema_of(
        {
            "request": {
                "type": "integer",
                "minimum": 1,
                "maximum": 1_000_000_000,
                "description": "the number that `go` answered",
            },
            "seconds": {
                "type": "number",
                "minimum": 0,
                "maximum": MAX_WAIT,
                "description": f"how long to wait at most; {MAX_WAIT:.0f} unless told",
            },
        },
        ("request",),
    )

    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        end = time.monotonic() + given.get("seconds", MAX_WAIT)
        result = {"code": "ran_out"}
        while result["code"] == "ran_out":
            left = max(min(end - time.monotonic(), _SLICE), _MIN_SLICE)
            words = ["wait", "request", str(given["request"])]
            result = await connection.request(left + ANSWER_TIMEOUT, words=words, timeout=left)
            if time.monotonic() >= end:
                break
        code = result["code"]
        summary = _ENDS.get(code, "It is not known to have arrived: `said` tells why.")
        return ToolAnswer(
            code, summary, robot_part_of(result), failed=code not in ("arrived", "ran_out")
        )


class CancelTool(Tool):
    """The tool that withdraws the assistant's waiting requests, or else cancels its goal."""

    name, title = "cancel", "Cancel its own goal"
    description = (
        "Cancel the goal that this assistant asked for and a person allowed, while it runs. Goals "
        "of people and other programs are not touched. In danger use `stop`."
    )
    hints = Hints()

    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        result = await connection.request(words=["cancel"])
        if result["code"] == "done":
            summary = "Withdrawn: no request of this assistant waits for a person any more."
            return ToolAnswer(result["code"], summary, robot_part_of(result))
        if result["code"] == "accepted":
            summary = "The robot accepts the cancel. `wait` tells when its goal has ended."
            return ToolAnswer(result["code"], summary, robot_part_of(result))
        summary = "Not cancelled, or not confirmed: `said` tells why. `stop` stops the robot."
        return failure(result["code"], summary, robot_part_of(result))


async def _goals(connection: ConsoleConnection) -> list[dict[str, Any]]:
    """Return `kind`, `title` and `schema` of each goal that the robot offers, harmless to show."""
    listed = (await connection.request(words=["goals"])).get("data")
    goals = [goal for goal in listed if isinstance(goal, dict)] if isinstance(listed, list) else []
    return [
        {
            "kind": goal["kind"],
            "title": sanitize(str(goal.get("title", ""))),
            "schema": _intact_schema(goal.get("schema")),
        }
        for goal in goals
        if isinstance(goal.get("kind"), str) and goal["kind"] == sanitize(goal["kind"])
    ]


def _intact_schema(schema: Any) -> dict[str, Any]:
    """Return a goal's schema, or `{"type": "object"}` if it is not fit to show."""
    is_one = isinstance(schema, dict) and schema.get("type") == "object"
    return schema if is_one and schema == sanitize(schema) else {"type": "object"}
