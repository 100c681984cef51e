"""The base of tools: a description for models, a schema, and a call."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.connection import ConsoleConnection
from archo_tui.assistant.tool_answer import ToolAnswer


class Hints(NamedTuple):
    """The annotations of a tool by MCP, which a client reads before it calls the tool.

    Attributes:
        reads_only: True if the tool changes nothing.
        destroys: True if its changes cannot be undone.
        is_idempotent: True if a second call with the same arguments changes nothing more.
        is_open: True if its effects reach things that this program does not know.
    """

    reads_only: bool = False
    destroys: bool = False
    is_idempotent: bool = True
    is_open: bool = False


READS = Hints(reads_only=True)


class Tool(ABC):
    """The base of an assistant's tools.

    Attributes:
        name: The name by which a model calls it.
        title: The name for people.
        description: The description for models: what it does and when to use it.
        hints: The annotations of MCP.
        schema: The JSON schema by which the arguments are checked; by default it takes none.
    """

    name: str
    title: str
    description: str
    hints: Hints = READS
    schema: dict[str, Any] = schema_of({})

    async def offered_schema(self, connection: ConsoleConnection) -> dict[str, Any]:
        """Return the schema that clients see: `schema`, or one that lists the robot's values.

        Args:
            connection: The connection to the console, which may be asked for them.
        """
        return self.schema

    @abstractmethod
    async def call(self, connection: ConsoleConnection, given: dict[str, Any]) -> ToolAnswer:
        """Run the tool, and return its answer, also if the console refuses.

        Args:
            connection: The connection to the console.
            given: Arguments that fit the schema.

        Raises:
            Unreached: There is no console, or it does not answer; `StopTool` answers that instead.
        """
