"""Error texts for a robot file that does not match the ROS graph. Pure functions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from archo_tui.nearest import nearest_hint


def unexpected_type(name: str, found: Sequence[str], expected: Collection[str]) -> str:
    """Return why the types of a topic or action do not fit; "" if they do, or if there is no type.

    A type that is not expected does not fit, nor do several types at once.

    Args:
        name: The topic or action.
        found: The types that the graph reports, as `package/msg/Name`.
        expected: The types that the robot file allows.
    """
    for kind in found:
        if kind not in expected:
            return f"{name} is {kind}: expected {' or '.join(expected)}"
    return f"{name} has several types: {', '.join(found)}" if len(found) > 1 else ""


def duplicate_servers(action: str, nodes: Sequence[str]) -> str:
    """Return the text by which a goal is refused whose action several nodes serve.

    ROS 2 delivers one goal request to all of them, so each would start to drive.

    Args:
        action: The action.
        nodes: The full names of the nodes.
    """
    return f"{action} is served by {' and '.join(nodes)}: each would drive; stop all but one"


def not_installed(name: str, kind: str) -> str:
    """Return the error text for a type whose package cannot be imported here.

    Args:
        name: The topic, action or service.
        kind: Its type.
    """
    return f"{name} is {kind}, which is not installed here"


def not_subscribed(name: str, kind: str, reason: str) -> str:
    """Return the error text for a topic to which rclpy makes no subscription, and its reason."""
    return f"{name} is {kind}, and cannot be subscribed to here: {reason}"


def unknown_field(kind: str, wanted: Iterable[tuple[str, str]], known: Collection[str]) -> str:
    """Return an error for the first field that a message type lacks, or "" if it has all.

    Args:
        kind: The type's name, for the text.
        wanted: Pairs of the place in the robot file (`FILE:LINE`) and the field's dotted path.
        known: Every dotted path that the type has.
    """
    for where, path in wanted:
        if path not in known:
            return f"{where}: {kind} has no field {path}{nearest_hint(path, known)}"
    return ""
