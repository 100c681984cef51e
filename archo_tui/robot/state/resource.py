"""A topic, a service or an action on the graph."""

from __future__ import annotations

from typing import NamedTuple

TOPIC, SERVICE, ACTION = "topic", "service", "action"


class Resource(NamedTuple):
    """A topic, a service or an action, and the nodes that publish or serve it.

    Recordings have the names of the attributes.
    """

    kind: str  # TOPIC, SERVICE or ACTION.
    name: str
    types: tuple[str, ...]  # Its types: several if nodes disagree.
    nodes: tuple[str, ...]  # The full names of the nodes that publish or serve it.
    # For a topic, a text with the remedy for each node that receives nothing, or may misread what
    # it receives.
    mismatches: tuple[str, ...] = ()
