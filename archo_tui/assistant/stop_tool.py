"""The STOP tool, which every assistant has."""

from __future__ import annotations

from typing import Any

from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.tool import Hints, Tool
from archo_tui.assistant.tool_answer import ToolAnswer, failure, robot_part_of
from archo_tui.client.connection import Unreached
from archo_tui.robot_file.model import NO_STOP
from archo_tui.safe_text import harmless

_BY_HAND = "Tell the people at the robot at once to use its hardware stop."


class StopTool(Tool):
    """The tool that stops the robot: no person is asked, and any argument still means STOP.

    Its answer is `done` only if every console that got the STOP has confirmed it.
    """

    name, title = "stop", "STOP the robot"
    description = (
        "STOP: stops the robot at once and keeps it stopped; voids what was asked before. Never "
        "asks, and overtakes every other call. Use it whenever in doubt. Only a person at the "
        "console can release it. It is a software stop and does not replace the hardware one."
    )
    hints = Hints()
    schema = {**schema_of({}), "additionalProperties": True}

    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        ignored = " What was given with it is ignored: STOP takes nothing." if given else ""
        try:
            results = await connection.stop()
        except Unreached as error:
            head, *rest = str(error).splitlines()
            robot = {"said": rest} if rest else None
            summary = f"STOP is not confirmed: {harmless(head)}. {_BY_HAND}{ignored}"
            return failure("lost", summary, robot)
        robot = {"consoles": [robot_part_of(result) for result in results]}
        bad = [result["code"] for result in results if result["code"] != "done"]
        if bad and all(NO_STOP in str(result.get("text")) for result in results):
            summary = (
                f"The robot has NO STOP. Cancelling every goal was asked for instead. {_BY_HAND}"
            )
            return failure(bad[0], f"{summary}{ignored}", robot)
        if bad:
            summary = (
                f"STOP was sent and is NOT confirmed: the robot may still move. {_BY_HAND}{ignored}"
            )
            return failure(bad[0], summary, robot)
        where = f", on {len(results)} consoles" if len(results) > 1 else ""
        summary = f"STOP is confirmed by the robot{where}. Only a person can release it.{ignored}"
        return ToolAnswer("done", summary, robot)
