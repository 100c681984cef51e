"""The base of tools: a description for models, a schema, and a call."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.tool_answer import ToolAnswer


class Hints(NamedTuple):
    """The annotations of a tool by MCP, which a client reads before it calls the tool."""

    reads_only: bool = False  # It changes nothing.
    destroys: bool = False  # Its changes cannot be undone.
    is_idempotent: bool = True  # A second equal call changes nothing more.
    is_open: bool = False  # Its effects reach things that this program does not know.


READS = Hints(reads_only=True)


class Tool(ABC):
    """The base of an assistant's tools."""

    name: str
    title: str  # For people.
    description: str  # For models: what it does and when to use it.
    hints: Hints = READS
    schema: dict[str, Any] = schema_of({})

    async def offered_schema(self, connection: ConsoleConnection) -> dict[str, Any]:
        """Return the schema that clients see: `schema`, or one that lists the robot's values."""
        return self.schema

    @abstractmethod
    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        """Run the tool with arguments that fit, and return its answer, or raise Unreached."""
