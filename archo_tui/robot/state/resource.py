"""A topic, a service or an action on the graph."""

from __future__ import annotations

from typing import NamedTuple

TOPIC, SERVICE, ACTION = "topic", "service", "action"


class Resource(NamedTuple):
    """A topic, a service or an action, and the nodes that publish or serve it.

    Recordings have the names of the attributes.

    Attributes:
        kind: TOPIC, SERVICE or ACTION.
        name: Its full name.
        types: Its types: several if nodes disagree.
        nodes: The full names of the nodes that publish or serve it.
        mismatches: For a topic, a text with the remedy for each node that receives nothing, or may
            misread what it receives.
    """

    kind: str
    name: str
    types: tuple[str, ...]
    nodes: tuple[str, ...]
    mismatches: tuple[str, ...] = ()
