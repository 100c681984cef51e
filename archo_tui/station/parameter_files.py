"""Parameter files and `-p` options given at the start, checked before the screen begins."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.base.yaml_text.bounded_yaml import YamlError
from archo_tui.ros.embedded.parameter_files import Override, matches, read

EVERY_NODE = "/**"  # The pattern of a parameter that is typed without a node.
_SIMILAR = 0.4  # Lower than difflib's 0.6: a distant name is a better hint than none.
_MAX_NAMED = 3  # Unknown nodes of a file that get a line each.
_PACKAGE = Path(__file__).parent.parent


def default_files() -> list[Path]:
    """Return ARCHO's own parameter files, sorted, in a checkout or in an installed wheel."""
    for folder in (_PACKAGE.parent / "config", _PACKAGE / "config"):
        found = sorted(folder.glob("*.yaml"))
        if found:
            return found
    return []


def load_files(files: Sequence[Path]) -> list[Override]:
    """Return the overrides of all files, in order; ArchoError names file and line."""
    overrides: list[Override] = []
    for path in files:
        try:
            overrides += read(path)
        except YamlError as error:
            raise ArchoError(str(error)) from None
        except OSError as error:
            raise ArchoError(f"{path}: cannot read the parameter file: {error.strerror}") from None
    return overrides


def parse_typed(ros_args: Sequence[str]) -> list[Override]:
    """Return the overrides of `-p [node:]name:=value` options, as text and in their order."""
    found = []
    for option, given in pairwise(ros_args):
        target, is_one, value = given.partition(":=")
        if option in ("-p", "--param") and is_one:
            node, _, name = target.rpartition(":")
            found.append(Override(node or EVERY_NODE, name, value, f"-p {given}"))
    return found


def unknown_lines(overrides: Iterable[Override], declared: dict[str, set[str]]) -> list[str]:
    """Return a line for each node and parameter that is named and does not exist.

    A file that names more than three such nodes gets one line for them. Wildcards in files are
    never wrong, since nodes share files; a parameter typed for every node must exist in one at
    least.
    """
    lines = []
    missing: dict[str, dict[str, str]] = {}  # By file, each node with where it is first named.
    for override in overrides:
        if override.pattern == EVERY_NODE and override.where.startswith("-p "):
            every = {name for names in declared.values() for name in names}
            if override.name not in every:
                near = nearest_hint(override.name, every, _SIMILAR)
                lines.append(f"{override.where}: no node has a parameter {override.name}{near}")
        if "*" in override.pattern:
            continue
        nodes = [node for node in declared if matches(override.pattern, node)]
        if not nodes:
            pattern = "/" + override.pattern.lstrip("/")
            file = override.where.rpartition(":")[0]
            missing.setdefault(file, {}).setdefault(pattern, override.where)
        for node in nodes:
            if override.name not in declared[node]:
                near = nearest_hint(override.name, declared[node], _SIMILAR)
                lines.append(f"{override.where}: {node} has no parameter {override.name}{near}")
    return [*_unknown_node_lines(missing, declared), *dict.fromkeys(lines)]


def _unknown_node_lines(
    missing: dict[str, dict[str, str]], declared: Iterable[str]
) -> Iterable[str]:
    """Yield a line for each node that is not here, or one for a file with many of them."""
    for file, nodes in missing.items():
        if len(nodes) > _MAX_NAMED:
            first = ", ".join([*nodes][:_MAX_NAMED])
            yield f"{file}: {len(nodes)} of its nodes are not here: {first} ..."
            continue
        for node, where in nodes.items():
            yield f"{where}: no node {node} here{nearest_hint(node, declared, _SIMILAR)}"
