"""What does not fit between a robot file and the ROS graph, in words. Pure functions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from archo_tui.base.nearest import nearest_hint


def unexpected_type(name: str, found: Sequence[str], expected: Collection[str]) -> str:
    """Return why the types of a topic or action do not fit; "" if they do, or there is none."""
    for kind in found:
        if kind not in expected:
            return f"{name} is {kind}: expected {' or '.join(expected)}"
    return f"{name} has several types: {', '.join(found)}" if len(found) > 1 else ""


def duplicate_servers(action: str, nodes: Sequence[str]) -> str:
    """Return why a goal is refused that several nodes would get, and each would drive."""
    return f"{action} is served by {' and '.join(nodes)}: each would drive; stop all but one"


def not_installed(name: str, kind: str) -> str:
    """Return the error text for a type whose package cannot be imported here."""
    return f"{name} is {kind}, which is not installed here"


def not_subscribed(name: str, kind: str, reason: str) -> str:
    """Return the error text for a topic to which rclpy makes no subscription, and its reason."""
    return f"{name} is {kind}, and cannot be subscribed to here: {reason}"


def unknown_field(kind: str, wanted: Iterable[tuple[str, str]], known: Collection[str]) -> str:
    """Return an error for the first of `wanted` (place, path) that a type lacks, or ""."""
    for where, path in wanted:
        if path not in known:
            return f"{where}: {kind} has no field {path}{nearest_hint(path, known)}"
    return ""
