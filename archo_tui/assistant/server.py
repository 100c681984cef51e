"""The MCP server on standard input and output, and the one file that imports the SDK."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any

import mcp_types as types
from mcp.server.lowlevel.server import Server
from mcp.server.stdio import stdio_server

from archo_tui import __version__
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.tool import Tool
from archo_tui.assistant.tool_answer import NOTE
from archo_tui.assistant.tools import available_tools, call_tool_by_name
from archo_tui.robot.stop.words import is_stop_text

_INSTRUCTIONS = (
    "A warehouse robot, as the operator's console sees it. You can look and STOP. {goals} "
    f"{NOTE} An assistant can release no STOP, set no parameter and approve no request."
)
_GOALS = {
    True: "You can ask for goals: a person at the console decides on each before anything moves.",
    False: "You cannot move it.",
}


def serve(*, goals: bool, to: str) -> None:
    """Serve MCP on standard input and output until the input ends, then close the connection."""
    asyncio.run(_serve(goals, to))


async def _serve(goals: bool, to: str) -> None:
    connection, known = ConsoleConnection(to), available_tools(goals=goals)

    async def list_tools(_context: Any, _asked: Any) -> types.ListToolsResult:
        return types.ListToolsResult(
            tools=[await _to_mcp_tool(tool, connection) for tool in known.values()]
        )

    async def call_tool(_context: Any, asked: types.CallToolRequestParams) -> types.CallToolResult:
        arguments = asked.arguments or {}
        answer, failed = await call_tool_by_name(known, connection, asked.name, arguments)
        text = types.TextContent(type="text", text=json.dumps(answer, ensure_ascii=False))
        return types.CallToolResult(content=[text], structured_content=answer, is_error=failed)

    server: Server[dict[str, Any]] = Server(
        "archo-tui",
        version=__version__,
        instructions=_INSTRUCTIONS.format(goals=_GOALS[goals]),
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )
    server.middleware.append(_take_any_stop)
    try:
        async with stdio_server() as (reading, writing):
            await server.run(reading, writing, server.create_initialization_options())
    finally:
        await connection.close()


async def _take_any_stop(ctx: Any, call_next: Callable[[Any], Awaitable[Any]]) -> Any:
    """Rewrite a call of any tool whose name means STOP as a call of `stop`.

    Malformed arguments, which the SDK would refuse, become an object.
    """
    params = ctx.params
    name = params.get("name") if ctx.method == "tools/call" and params else None
    if isinstance(name, str) and is_stop_text(name):
        given = params.get("arguments")
        given = given if isinstance(given, dict) else {} if given is None else {"given": given}
        kept = {name: value for name, value in params.items() if name == "_meta"}
        ctx = replace(ctx, params={"name": "stop", "arguments": given, **kept})
    return await call_next(ctx)


async def _to_mcp_tool(tool: Tool, connection: ConsoleConnection) -> types.Tool:
    hints = tool.hints
    return types.Tool(
        name=tool.name,
        title=tool.title,
        description=tool.description,
        input_schema=await tool.offered_schema(connection),
        annotations=types.ToolAnnotations(
            title=tool.title,
            read_only_hint=hints.reads_only,
            destructive_hint=hints.destroys,
            idempotent_hint=hints.is_idempotent,
            open_world_hint=hints.is_open,
        ),
    )
