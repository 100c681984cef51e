"""A robot file against the graph: what does not fit is named, and left alone. Pure."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Sequence


def types_fault(name: str, found: Sequence[str], expected: Collection[str]) -> str:
    """What is wrong with the types that a topic or action has, or an empty string."""
    for kind in found:
        if kind not in expected:
            return f"{name} is {kind}: expected {' or '.join(expected)}"
    return f"{name} has several types: {', '.join(found)}" if len(found) > 1 else ""


def several(action: str, nodes: Sequence[str]) -> str:
    """Why a goal is not sent: one request reaches all the servers of its action."""
    return f"{action} is served by {' and '.join(nodes)}: each would drive; stop all but one"


def missing(name: str, kind: str) -> str:
    """Of a type that cannot be imported."""
    return f"{name} is {kind}, which is not installed here"


def fields_fault(kind: str, wanted: Iterable[tuple[str, str]], known: Collection[str]) -> str:
    """The first `(where, path)` that the type does not have, or an empty string."""
    for where, path in wanted:
        if path not in known:
            near = difflib.get_close_matches(path, known, n=1)
            hint = f" (nearest: {near[0]})" if near else ""
            return f"{where}: {kind} has no field {path}{hint}"
    return ""
