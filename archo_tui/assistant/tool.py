"""A tool: what a model is told of it, what it takes, and what carries it out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

from archo_tui.assistant.answer import Answer
from archo_tui.assistant.arguments import schema_of
from archo_tui.assistant.link import Link


class Hints(NamedTuple):
    """What a client is told of a tool before it is called; MCP's annotations."""

    reads_only: bool = False
    destroys: bool = False
    is_idempotent: bool = True
    is_open: bool = False  # its effects reach what nobody here knows


READS = Hints(reads_only=True)


class Tool(ABC):
    """One of those that an assistant has; never more than nine."""

    name: str
    title: str
    description: str
    hints: Hints = READS
    schema: dict[str, Any] = schema_of({})

    async def offered_schema(self, link: Link) -> dict[str, Any]:
        """The schema that clients see, which may say more than the one that is checked."""
        return self.schema

    @abstractmethod
    async def call(self, link: Link, given: dict[str, Any]) -> Answer:
        """Carry it out; what is given fits the schema. Raises Unreached."""
