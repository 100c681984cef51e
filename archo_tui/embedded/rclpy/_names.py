"""Names of the ROS graph: what is allowed, how relative and private ones expand, remapping."""

from __future__ import annotations

import re
from typing import NamedTuple

from rclpy.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NameValidationException,
)

_FULL_MAX = 247  # RMW_TOPIC_MAX_NAME_LENGTH
_NAME_MAX = 255  # RMW_NODE_NAME_MAX_NAME_LENGTH


class Remap(NamedTuple):
    """One `[node:]from:=to` rule; `node` is None when it holds for every node."""

    node: str | None
    match: str
    replacement: str


def validate_node_name(name: str) -> None:
    """Raises InvalidNodeNameException."""
    if not name:
        raise InvalidNodeNameException(name, "node name must not be empty", 0)
    bad = re.search(r"[^A-Za-z0-9_]", name)
    if bad:
        raise InvalidNodeNameException(
            name,
            "node name must not contain characters other than alphanumerics or '_'",
            bad.start(),
        )
    if name[0].isdigit():
        raise InvalidNodeNameException(name, "node name must not start with a number", 0)
    if len(name) > _NAME_MAX:
        raise InvalidNodeNameException(name, "node name length should not exceed 255", _NAME_MAX)


def validate_namespace(namespace: str) -> None:
    """Raises InvalidNamespaceException unless `namespace` is `/` or an absolute name."""
    if not namespace.startswith("/"):
        raise InvalidNamespaceException(
            namespace, "namespace must be absolute, it must lead with a '/'", 0
        )
    if namespace != "/":
        _check(namespace, InvalidNamespaceException, "namespace", r"[^A-Za-z0-9_/]")


def expand(name: str, node: str, namespace: str, *, is_service: bool = False) -> str:
    """The fully qualified form of a topic or service name, as seen from a node.

    Raises InvalidTopicNameException or InvalidServiceNameException.
    """
    error = InvalidServiceNameException if is_service else InvalidTopicNameException
    kind = "service name" if is_service else "topic name"
    if not name:
        raise error(name, f"{kind} must not be empty", 0)
    _check(name, error, kind, r"[^A-Za-z0-9_/{}~]")
    if "~" in name[1:]:
        raise error(name, f"{kind} must not have a '~' after the start", name.index("~", 1))
    base = "" if namespace == "/" else namespace
    for found in re.findall(r"\{(.*?)\}", name):
        if found not in ("node", "ns", "namespace"):
            raise ValueError(f"{kind} {name!r} is invalid: unknown substitution '{{{found}}}'")
    name = name.replace("{node}", node)
    name = name.replace("{ns}", namespace).replace("{namespace}", namespace)
    if name.startswith("~"):
        name = f"{base}/{node}{name[1:]}"
    elif not name.startswith("/"):
        name = f"{base}/{name}"
    if len(name) > _FULL_MAX:
        raise error(name, f"{kind} length should not exceed '{_FULL_MAX}'", _FULL_MAX)
    return name


def remapped(full_name: str, node: str, namespace: str, rules: tuple[Remap, ...]) -> str:
    """`full_name` after the first rule that names it (both sides expand as the node's names do)."""
    for rule in rules:
        if rule.match.startswith("__") or rule.node not in (None, node):
            continue
        if expand(rule.match, node, namespace) == full_name:
            return expand(rule.replacement, node, namespace)
    return full_name


def special(rules: tuple[Remap, ...], node: str, *matches: str) -> str | None:
    """The replacement of `__node` or `__ns` for this node, or None."""
    for rule in rules:
        if rule.match in matches and rule.node in (None, node):
            return rule.replacement
    return None


def _check(name: str, error: type[NameValidationException], kind: str, allowed: str) -> None:
    make: type[InvalidTopicNameException] = error  # type: ignore[assignment]
    bad = re.search(allowed, name)
    if bad:
        raise make(
            name,
            f"{kind} must not contain characters other than alphanumerics, '_', '~', '{{', or '}}'",
            bad.start(),
        )
    if name.endswith("/"):
        raise make(name, f"{kind} must not end with a forward slash", len(name) - 1)
    if "//" in name:
        raise make(name, f"{kind} must not contain repeated '/'", name.index("//"))
    digit = re.search(r"(^|/)\d", name)
    if digit:
        raise make(name, f"{kind} token must not start with a number", digit.start())
