"""The tool that everybody has: STOP. It never asks, and never waits behind anything."""

from __future__ import annotations

from typing import Any

from archo_tui.assistant.answer import Answer, failure, said
from archo_tui.assistant.link import Link
from archo_tui.assistant.tool import Hints, Tool
from archo_tui.remote.client import Unreached
from archo_tui.robot.text import harmless

_BY_HAND = "Tell the people at the robot at once to use its hardware stop."


class Stop(Tool):
    """STOP."""

    name, title = "stop", "STOP the robot"
    description = (
        "STOP: stops the robot at once and keeps it stopped; voids what was asked before. Never "
        "asks, and overtakes every other call. Use it whenever in doubt. Only a person at the "
        "console can release it. It is a software stop and does not replace the hardware one."
    )
    hints = Hints()

    async def call(self, link: Link, given: dict[str, Any]) -> Answer:
        try:
            results = await link.stop()
        except Unreached as error:
            head, *rest = str(error).splitlines()
            robot = {"said": rest} if rest else None
            return failure("lost", f"STOP is not confirmed: {harmless(head)}. {_BY_HAND}", robot)
        robot = {"consoles": [said(result) for result in results]}
        bad = [result["code"] for result in results if result["code"] != "done"]
        if bad:
            summary = f"STOP was sent and is NOT confirmed: the robot may still move. {_BY_HAND}"
            return failure(bad[0], summary, robot)
        where = f", on {len(results)} consoles" if len(results) > 1 else ""
        summary = f"STOP is confirmed by the robot{where}. Only a person can release it."
        return Answer("done", summary, robot)
