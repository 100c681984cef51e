"""The list of tools. None releases a STOP, sets a parameter, allows a goal or hosts a node."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.assistant.arguments import InvalidArguments, check_arguments, shorten
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.goal_tools import CancelTool, GoTool, WaitTool
from archo_tui.assistant.reading_tools import (
    EchoTool,
    EventsTool,
    HistoryTool,
    InterfaceTool,
    ParametersTool,
    StatusTool,
)
from archo_tui.assistant.stop_tool import StopTool
from archo_tui.assistant.tool import Tool
from archo_tui.assistant.tool_answer import ToolAnswer, failure
from archo_tui.client.connection import Unreached
from archo_tui.robot.stop.words import is_stop_text
from archo_tui.safe_text import harmless


def available_tools(*, goals: bool) -> dict[str, Tool]:
    """Return new tools by name: those that read, STOP, and with `goals` those for goals."""
    made: list[Tool] = [
        *(StatusTool(), EventsTool(), HistoryTool(), ParametersTool()),
        *(EchoTool(), InterfaceTool(), StopTool()),
    ]
    if goals:
        made += [GoTool(), WaitTool(), CancelTool()]
    return {tool.name: tool for tool in made}


async def call_tool_by_name(
    known: Mapping[str, Tool], connection: ConsoleConnection, name: str, given: dict[str, Any]
) -> tuple[dict[str, Any], bool]:
    """Run a tool, and return its answer as a JSON object, and True if it failed.

    Mistakes and an unreached console are answered, too, not raised. Any name that means STOP runs
    `stop`.
    """
    answer = await _run_tool(known, connection, name, given)
    return answer.as_data(connection.take_notice()), answer.failed


async def _run_tool(
    known: Mapping[str, Tool], connection: ConsoleConnection, name: str, given: dict[str, Any]
) -> ToolAnswer:
    tool = known.get("stop" if is_stop_text(name) else name)
    if tool is None:
        others = f"the tools are {', '.join(known)}"
        return failure("misuse", f"no tool {shorten(name)}: {others}; the rest a person does.")
    try:
        check_arguments(tool.schema, given)
        return await tool.call(connection, given)
    except InvalidArguments as error:
        return failure("misuse", f"{error}. Nothing was sent.")
    except Unreached as error:
        head, *rest = str(error).splitlines()
        return failure("unreached", harmless(head), {"said": rest} if rest else None)
