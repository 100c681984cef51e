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
    """A remapping rule `[node:]from:=to`.

    `match` is the name to replace; `__node`, `__name` and `__ns` stand for the node's own.
    """

    node: str | None
    match: str
    replacement: str


_FULL = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_NODE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# A topic's or service's name as written, with `_` for each `{substitution}`.
_TOPIC = re.compile(r"~|(?!.*/\Z)(?!(.*/)?\d)~?[A-Za-z0-9_/]+")
_LONGEST_NODE, _LONGEST_TOPIC, _LONGEST_NAMESPACE = 255, 247, 245
_WORDS = "letters, digits and _ are allowed, and no digit first"


def node_name_problem(name: str) -> str:
    """Return what is wrong with a node's name, or ""."""
    return _problem(_NODE, name, _LONGEST_NODE, _WORDS)


def topic_problem(name: str) -> str:
    """Return what is wrong with a topic's or service's name as written, or ""."""
    plain = re.sub(r"\{[^{}/]*\}", lambda found: "_" * len(found[0]), name)
    return _problem(_TOPIC, plain, len(plain), f"between its /, {_WORDS}; ~ may begin it")


def full_topic_problem(name: str) -> str:
    """Return what is wrong with a topic's or service's name on the graph, or ""."""
    return _problem(_FULL, name, _LONGEST_TOPIC, f"after each /, {_WORDS}")


def namespace_problem(name: str) -> str:
    """Return what is wrong with a namespace, or ""."""
    if name == "/":
        return ""
    return _problem(_FULL, name, _LONGEST_NAMESPACE, f"after each /, {_WORDS}")


def _problem(form: re.Pattern[str], name: str, longest: int, rule: str) -> str:
    if not isinstance(name, str):
        raise TypeError(f"a name is a str, not {type(name).__name__}")
    if not name:
        return "it must not be empty"
    if not form.fullmatch(name):
        return rule
    return f"it is longer than {longest} characters" if len(name) > longest else ""


def check_node(name: str, namespace: str) -> None:
    """Raise InvalidNodeNameException or InvalidNamespaceException unless both are valid."""
    if problem := node_name_problem(name):
        raise InvalidNodeNameException(name, problem)
    if problem := namespace_problem(namespace):
        raise InvalidNamespaceException(namespace, problem)


def check_topic(name: str, problem: str, *, is_service: bool) -> None:
    """Raise InvalidTopicNameException or InvalidServiceNameException if there is a problem."""
    if problem:
        kind = InvalidServiceNameException if is_service else InvalidTopicNameException
        raise kind(name, problem)


def expand(name: str, node: str, namespace: str) -> str:
    """Return the fully qualified form of a topic or service name that a node uses."""
    problem = topic_problem(name)
    if problem:
        raise ValueError(f"topic name '{name}' is invalid: {problem}")
    known = {"{node}": node, "{ns}": namespace, "{namespace}": namespace}
    for found in re.findall(r"\{.*?\}", name):
        if found not in known:
            raise ValueError(f"topic name '{name}' is invalid: unknown substitution: {found}")
        name = name.replace(found, known[found])
    base = "" if namespace == "/" else namespace
    if name.startswith("~"):
        return f"{base}/{node}{name[1:]}"
    return name if name.startswith("/") else f"{base}/{name}"


def remapped(full_name: str, node: str, namespace: str, rules: tuple[Remap, ...]) -> str:
    """Return the name that the first fitting rule gives a topic or service, else `full_name`."""
    for rule in rules:
        fits = rule.node in (None, node) and rule.match[:2] != "__"
        if fits and expand(rule.match, node, namespace) == full_name:
            return expand(rule.replacement, node, namespace)
    return full_name


def renamed(rules: tuple[Remap, ...], node: str, *matches: str) -> str | None:
    """Return the name or namespace that the first fitting rule gives a node, or None."""
    fitting = (r.replacement for r in rules if r.match in matches and r.node in (None, node))
    return next(fitting, None)
