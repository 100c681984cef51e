"""Full names on the graph."""

from __future__ import annotations


def in_namespace(namespace: str, name: str) -> str:
    """Return a name of the robot file as a full name in a namespace.

    A name that begins with `/` is full already, and is returned as it is.
    """
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def logger_node(logger: str) -> str:
    """Return the full name of the node whose logger has a name such as `north.lamp`."""
    return "/" + logger.replace(".", "/")


def not_offered(name: str) -> str:
    """Return the text that no node offers a service or an action."""
    return f"{name} is not offered by any node"
