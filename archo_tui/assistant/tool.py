"""The base of tools: a description for models, a schema, and a call."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.tool_answer import ToolAnswer


class Hints(NamedTuple):
    """The annotations of MCP, which a client reads before it calls a tool.

    Attributes:
        reads_only: True if the tool changes nothing.
        destroys: True if its changes cannot be undone.
        is_idempotent: True if a second call with the same arguments changes nothing.
        is_open: True if its effects reach things that nobody here knows.
    """

    reads_only: bool = False
    destroys: bool = False
    is_idempotent: bool = True
    is_open: bool = False


READS = Hints(reads_only=True)


class Tool(ABC):
    """A tool of an assistant, of which there are never more than a dozen."""

    name: str
    title: str
    description: str
    hints: Hints = READS
    schema: dict[str, Any] = schema_of({})

    async def offered_schema(self, connection: ConsoleConnection) -> dict[str, Any]:
        """Return the schema that clients see, which may be stricter than the checked one."""
        return self.schema

    @abstractmethod
    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        """Run the tool.

        Args:
            connection: The connection to the console.
            given: Arguments that fit the schema.

        Raises:
            Unreached: There is no console, or it does not answer.
        """
