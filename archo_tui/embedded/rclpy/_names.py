"""Names of the ROS graph: what is allowed, how relative and private ones expand, remapping."""

from __future__ import annotations

import re
from typing import NamedTuple

from rclpy.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)


class Remap(NamedTuple):
    """A remapping rule `[node:]from:=to`; `kind` is `rostopic` or `rosservice`, or None for both.

    `match` is the name to replace; `__node`, `__name` and `__ns` stand for the node's own.
    """

    node: str | None
    match: str
    replacement: str
    kind: str | None = None


Problem = tuple[str, int] | None  # What is wrong with a name, and at which character.

# For each kind of name, what is wrong with it by a pattern that finds the wrong character.
_NODE = (
    (r"\A\Z", "node name must not be empty"),
    (r"[^A-Za-z0-9_]", "node name must not contain characters other than alphanumerics or '_'"),
    (r"\A\d", "node name must not start with a number"),
    (r"\A.{254}.(?=.)", "node name length should not exceed '255'"),
)
_TOPIC = (
    (r"\A\Z", "topic name must not be empty string"),
    (r"/\Z", "topic name must not end with a forward slash"),
    (
        r"[^A-Za-z0-9_/{}~]",
        "topic name must not contain characters other than alphanumerics, '_', '~', '{', or '}'",
    ),
    (r"(?<=.)~", "topic name must not have tilde '~' unless it is the first character"),
    (r"[{}]", "topic name must not have unmatched (unbalanced) curly braces '{}'"),
    (r"(?:\A|(?<=/))\d", "topic name token must not start with a number"),
)


def _absolute(kind: str, longest: int) -> tuple[tuple[str, str], ...]:
    return (
        (r"\A\Z", f"{kind} must not be empty"),
        (r"\A[^/]", f"{kind} must be absolute, it must lead with a '/'"),
        (r"/\Z", f"{kind} must not end with a '/'"),
        (
            r"[^A-Za-z0-9_/]",
            f"{kind} must not contain characters other than alphanumerics, '_', or '/'",
        ),
        (r"(?<=/)/", f"{kind} must not contain repeated '/'"),
        (r"(?<=/)\d", f"{kind} must not have a token that starts with a number"),
        (rf"\A.{{{longest - 1}}}.(?=.)", f"{kind} length should not exceed '{longest}'"),
    )


_FULL_TOPIC, _NAMESPACE = _absolute("topic name", 247), _absolute("namespace", 245)


def _problem(rules: tuple[tuple[str, str], ...], name: str) -> Problem:
    if not isinstance(name, str):
        raise TypeError(f"a name is a str, not {type(name).__name__}")
    for pattern, said in rules:
        found = re.search(pattern, name)
        if found:
            return said, found.end() - 1 if len(found[0]) > 1 else found.start()
    return None


def node_name_problem(name: str) -> Problem:
    """Return what is wrong with a node's name, and the index of a wrong character, or None."""
    return _problem(_NODE, name)


def topic_problem(name: str) -> Problem:
    """Return what is wrong with a topic or service name as written, with an index, or None."""
    return _problem(_TOPIC, re.sub(r"\{[^{}/]*\}", lambda found: "_" * len(found[0]), name))


def full_topic_problem(name: str) -> Problem:
    """Return what is wrong with a topic or service name on the graph, with an index, or None."""
    return _problem(_FULL_TOPIC, name)


def namespace_problem(name: str) -> Problem:
    """Return what is wrong with a namespace, and the index of a wrong character, or None."""
    return None if name == "/" else _problem(_NAMESPACE, name)


def check_node(name: str, namespace: str) -> None:
    """Raise InvalidNodeNameException or InvalidNamespaceException unless both are valid."""
    problem = node_name_problem(name)
    if problem:
        raise InvalidNodeNameException(name, *problem)
    problem = namespace_problem(namespace)
    if problem:
        raise InvalidNamespaceException(namespace, *problem)


def check_topic(name: str, problem: Problem, *, is_service: bool) -> None:
    """Raise InvalidTopicNameException or InvalidServiceNameException if there is a problem."""
    if problem:
        kind = InvalidServiceNameException if is_service else InvalidTopicNameException
        raise kind(name, *problem)


def expand(name: str, node: str, namespace: str) -> str:
    """Return the fully qualified form of a topic or service name that a node uses."""
    problem = topic_problem(name)
    if problem:
        raise ValueError(f"topic name '{name}' is invalid: {problem[0]}")
    known = {"{node}": node, "{ns}": namespace, "{namespace}": namespace}
    for found in re.findall(r"\{.*?\}", name):
        if found not in known:
            raise ValueError(f"topic name '{name}' is invalid: unknown substitution: {found}")
        name = name.replace(found, known[found])
    base = "" if namespace == "/" else namespace
    if name.startswith("~"):
        return f"{base}/{node}{name[1:]}"
    return name if name.startswith("/") else f"{base}/{name}"


def remapped(
    full_name: str, node: str, namespace: str, rules: tuple[Remap, ...], *, is_service: bool
) -> str:
    """Return the name that the first fitting rule gives a topic or service, else `full_name`."""
    kinds = (None, "rosservice" if is_service else "rostopic")
    for rule in rules:
        fits = rule.node in (None, node) and rule.kind in kinds and rule.match[:2] != "__"
        if fits and expand(rule.match, node, namespace) == full_name:
            return expand(rule.replacement, node, namespace)
    return full_name


def renamed(rules: tuple[Remap, ...], node: str, *matches: str) -> str | None:
    """Return the name or namespace that the first fitting rule gives a node, or None."""
    fitting = (r.replacement for r in rules if r.match in matches and r.node in (None, node))
    return next(fitting, None)
