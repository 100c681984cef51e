"""A topic, service or action that was seen on the graph, and why it is taken for a part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal


@dataclass(frozen=True)
class Sighting:
    """A topic, service or action that was seen on the graph."""

    kind: Literal["topic", "service", "action"]
    name: str
    types: tuple[str, ...]  # Usually one.
    nodes: tuple[str, ...] = ()  # Full names of those that publish or serve it.
    lifecycles: Mapping[str, str] = field(default_factory=dict)  # Of managed nodes, by node.
    was_listened_to: bool = True  # False for a topic whose type is not installed or not used.
    rate: float | None = None  # Messages in a second; None before the second one.
    # The primitive fields of the last message by dotted path.
    values: Mapping[str, Any] = field(default_factory=dict)
    # The types of all fields of the goal or request by dotted path; None if not installed, and for
    # a topic.
    goal: Mapping[str, str] | None = None
    feedback: Mapping[str, str] = field(default_factory=dict)
    result: Mapping[str, str] = field(default_factory=dict)


def topic_reason(sighting: Sighting, kind: str) -> str:
    """Return why a topic is proposed, in a line: its type, rate and publishers."""
    rate = f", {sighting.rate:.1f} Hz" if sighting.rate else ""
    rate = rate or (", too few messages to tell a rate" if sighting.values else ", no message came")
    by = f", published by {nodes_text(sighting)}" if sighting.nodes else ", which nobody publishes"
    others = [other for other in sighting.types if other != kind]
    more = f" (and of {' and '.join(others)})" if others else ""
    came = rate if sighting.nodes and sighting.was_listened_to else ""
    return f"{sighting.name} is a {kind}{more}{came}{by}"


def served_reason(sighting: Sighting) -> str:
    """Return why a service or action is proposed, in a line: its types, and who serves it."""
    twice = ": several serve it, so it is refused" if len(sighting.nodes) > 1 else ""
    by = f" served by {nodes_text(sighting)}" if sighting.nodes else ""
    return f"{sighting.name} is a {', '.join(sighting.types)}{by}{twice}"


def nodes_text(sighting: Sighting) -> str:
    """Return the nodes that publish or serve a sighting; of a managed node also its state."""
    states = sighting.lifecycles
    return ", ".join(f"{n} ({states[n]})" if n in states else n for n in sighting.nodes)
