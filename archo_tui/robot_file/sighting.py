"""A topic, service or action that was seen on the graph, and why it is taken for a part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal


@dataclass(frozen=True)
class Sighting:
    """A topic, service or action that was seen on the graph.

    Attributes:
        kind: "topic", "service" or "action".
        name: Its full name.
        types: Its types; usually one.
        nodes: The full names of the nodes that publish or serve it.
        lifecycles: The states of those nodes that are managed, by node.
        was_listened_to: False for a topic without a subscription: its type is not installed, or not
            one that a robot file can use.
        rate: Messages in a second; None before the second message.
        values: The primitive fields of the last message by dotted path.
        goal: The types of all fields of the goal or request by dotted path; None if the type is not
            installed, and for a topic.
        feedback: The same of an action's feedback.
        result: The same of an action's result.
    """

    kind: Literal["topic", "service", "action"]
    name: str
    types: tuple[str, ...]
    nodes: tuple[str, ...] = ()
    lifecycles: Mapping[str, str] = field(default_factory=dict)
    was_listened_to: bool = True
    rate: float | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    goal: Mapping[str, str] | None = None
    feedback: Mapping[str, str] = field(default_factory=dict)
    result: Mapping[str, str] = field(default_factory=dict)


def topic_reason(sighting: Sighting, kind: str) -> str:
    """Return why a topic is proposed, in a line: its type, rate and publishers.

    Args:
        sighting: The topic.
        kind: The one of its types for which it is proposed.
    """
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
