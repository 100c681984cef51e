"""Full names on the graph."""

from __future__ import annotations


def in_namespace(namespace: str, name: str) -> str:
    """Return the full name of a name in a namespace; a name that begins with `/` is full."""
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def logger_node(logger: str) -> str:
    """Return the full name of the node that has a logger of that name (`north.lamp`)."""
    return "/" + logger.replace(".", "/")


def not_offered(name: str) -> str:
    """Return the text for a service or an action that no node offers."""
    return f"{name} is not offered by any node"
