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

_FULL_MAX = 247  # RMW_TOPIC_MAX_NAME_LENGTH
_NAME_MAX = 255  # RMW_NODE_NAME_MAX_NAME_LENGTH
_NAMESPACE_MAX = 245  # RMW_NAMESPACE_MAX_LENGTH


class Remap(NamedTuple):
    """A remapping rule `[node:]from:=to`."""

    node: str | None
    match: str
    replacement: str
    kind: str | None = None


Problem = tuple[str, int] | None  # What is wrong with a name, and at which character.


def validate_node_name(name: str) -> None:
    """Raise InvalidNodeNameException unless `name` is valid for a node."""
    problem = node_name_problem(name)
    if problem:
        raise InvalidNodeNameException(name, *problem)


def validate_namespace(namespace: str) -> None:
    """Raise InvalidNamespaceException unless `namespace` is `/` or a valid absolute name."""
    problem = namespace_problem(namespace)
    if problem:
        raise InvalidNamespaceException(namespace, *problem)


def validate_topic_name(name: str, *, is_service: bool = False) -> None:
    """Check the name of a topic or service as a program writes it (`x`, `~/x`, `/x`)."""
    problem = topic_problem(name)
    if problem and is_service:
        raise InvalidServiceNameException(name, *problem)
    if problem:
        raise InvalidTopicNameException(name, *problem)


def validate_full_topic_name(name: str, *, is_service: bool = False) -> None:
    """Check the name of a topic or service as it is on the graph, expanded."""
    problem = full_topic_problem(name)
    if problem and is_service:
        raise InvalidServiceNameException(name, *problem)
    if problem:
        raise InvalidTopicNameException(name, *problem)


def node_name_problem(name: str) -> Problem:
    """Return ROS's error text for a node's name and the index of a wrong character, or None."""
    if not name:
        return "node name must not be empty", 0
    bad = re.search(r"[^A-Za-z0-9_]", name)
    if bad:
        said = "node name must not contain characters other than alphanumerics or '_'"
        return said, bad.start()
    if name[0].isdigit():
        return "node name must not start with a number", 0
    if len(name) > _NAME_MAX:
        return f"node name length should not exceed '{_NAME_MAX}'", _NAME_MAX - 1
    return None


def topic_problem(name: str) -> Problem:
    """Return ROS's error text and an index for a topic's or service's unexpanded name, or None.

    The index is that of the wrong character.
    """
    if not isinstance(name, str):
        raise TypeError(f"a name is a str, not {type(name).__name__}")
    if not name:
        return "topic name must not be empty string", 0
    if name.endswith("/"):
        return "topic name must not end with a forward slash", len(name) - 1
    bad = re.search(r"[^A-Za-z0-9_/{}~]", name)
    if bad:
        said = (
            "topic name must not contain characters other than alphanumerics, '_', '~', '{', or '}'"
        )
        return said, bad.start()
    if "~" in name[1:]:
        said = "topic name must not have tilde '~' unless it is the first character"
        return said, name.index("~", 1)
    bare = re.sub(r"\{[^{}]*\}", lambda found: " " * len(found[0]), name)
    brace = re.search(r"[{}]", bare)
    if brace:
        said = "topic name must not have unmatched (unbalanced) curly braces '{}'"
        return said, brace.start()
    digit = re.search(r"(?:^|/)(\d)", name)
    return ("topic name token must not start with a number", digit.start(1)) if digit else None


def full_topic_problem(name: str) -> Problem:
    """Return ROS's error text and an index for a topic's or service's expanded name, or None.

    The index is that of the wrong character.
    """
    if not name:
        return "topic name must not be empty", 0
    if not name.startswith("/"):
        return "topic name must be absolute, it must lead with a '/'", 0
    if name.endswith("/"):
        return "topic name must not end with a '/'", len(name) - 1
    problem = _tokens_problem(name, "topic name")
    if problem is None and len(name) > _FULL_MAX:
        return f"topic length should not exceed '{_FULL_MAX}'", _FULL_MAX - 1
    return problem


def namespace_problem(name: str) -> Problem:
    """Return ROS's error text for a namespace and the index of the wrong character, or None."""
    if not name:
        return "namespace must not be empty", 0
    if not name.startswith("/"):
        return "namespace must be absolute, it must lead with a '/'", 0
    if name == "/":
        return None
    if name.endswith("/"):
        return "namespace must not end with a '/', unless only a '/'", len(name) - 1
    problem = _tokens_problem(name, "namespace")
    if problem is None and len(name) > _NAMESPACE_MAX:
        return f"namespace should not exceed '{_NAMESPACE_MAX}'", _NAMESPACE_MAX - 1
    return problem


def _tokens_problem(name: str, kind: str) -> Problem:
    bad = re.search(r"[^A-Za-z0-9_/]", name)
    if bad:
        said = f"{kind} must not contain characters other than alphanumerics, '_', or '/'"
        return said, bad.start()
    if "//" in name:
        return f"{kind} must not contain repeated '/'", name.index("//") + 1
    digit = re.search(r"/(\d)", name)
    if digit:
        return f"{kind} must not have a token that starts with a number", digit.start(1)
    return None


def expand(name: str, node: str, namespace: str) -> str:
    """Return the fully qualified form of a topic or service name that a node uses.

    `~`, `{node}`, `{ns}` and `{namespace}` are replaced, and a relative name is put under the
    namespace. The result is not checked.
    """
    problem = topic_problem(name)
    if problem:
        raise ValueError(f"topic name '{name}' is invalid: {problem[0]}")
    for found in re.findall(r"\{.*?\}", name):
        if found not in ("{node}", "{ns}", "{namespace}"):
            raise ValueError(f"topic name '{name}' is invalid: unknown substitution: {found}")
    base = "" if namespace == "/" else namespace
    name = name.replace("{node}", node)
    name = name.replace("{ns}", namespace).replace("{namespace}", namespace)
    if name.startswith("~"):
        return f"{base}/{node}{name[1:]}"
    return name if name.startswith("/") else f"{base}/{name}"


def remapped(
    full_name: str, node: str, namespace: str, rules: tuple[Remap, ...], *, is_service: bool
) -> str:
    """Return the name that the first fitting rule gives for a topic or service, else `full_name`.

    Both sides of a rule are expanded as names that the node uses. Rules for another node, for the
    other kind of name, or for the node's own name do not fit.
    """
    kind = "rosservice" if is_service else "rostopic"
    for rule in rules:
        if rule.match.startswith("__") or rule.node not in (None, node):
            continue
        if rule.kind not in (None, kind):
            continue
        if expand(rule.match, node, namespace) == full_name:
            return expand(rule.replacement, node, namespace)
    return full_name


def renamed(rules: tuple[Remap, ...], node: str, *matches: str) -> str | None:
    """Return the name or namespace that the first fitting rule gives a node, or None."""
    for rule in rules:
        if rule.match in matches and rule.node in (None, node):
            return rule.replacement
    return None
