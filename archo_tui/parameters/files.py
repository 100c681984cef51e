"""Parameter files given at the start: checked before the terminal is touched."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from archo_tui.embedded.parameter_files import Override, matches, read
from archo_tui.errors import ArchoError
from archo_tui.yaml_text.bounded_yaml import YamlError

EVERY_NODE = "/**"  # the pattern of what is typed without a node
_FEW = 3  # nodes of a file that are named one by one
_PACKAGE = Path(__file__).parent.parent


def default_files() -> list[Path]:
    """The project's own files: `config/` of the checkout, or the copy inside an installed wheel."""
    for folder in (_PACKAGE.parent / "config", _PACKAGE / "config"):
        found = sorted(folder.glob("*.yaml"))
        if found:
            return found
    return []


def load(files: Sequence[Path]) -> list[Override]:
    """Read all files. Raises ArchoError that names file and line."""
    overrides: list[Override] = []
    for path in files:
        try:
            overrides += read(path)
        except YamlError as error:
            raise ArchoError(str(error)) from None
        except OSError as error:
            raise ArchoError(f"{path}: cannot read the parameter file: {error.strerror}") from None
    return overrides


def typed(ros_args: Sequence[str]) -> list[Override]:
    """Return the overrides that are typed: `-p name:=value`, or `-p node:name:=value`."""
    found = []
    for option, given in pairwise(ros_args):
        target, is_one, value = given.partition(":=")
        if option in ("-p", "--param") and is_one:
            node, _, name = target.rpartition(":")
            found.append(Override(node or EVERY_NODE, name, value, f"-p {given}"))
    return found


def unknown(overrides: Iterable[Override], declared: dict[str, set[str]]) -> list[str]:
    """Return a line for each node and parameter that is named and not there, with the nearest.

    A file that names more than a few such nodes, as one for a whole stack, gets one line for them.

    `declared` holds the parameter names of each fully qualified node name. Files are shared between
    nodes, so their wildcards are never wrong; what is typed for every node is one node's at least.
    """
    lines = []
    missing: dict[str, dict[str, str]] = {}  # by file: the nodes, and where each is first named
    for override in overrides:
        if override.pattern == EVERY_NODE and override.where.startswith("-p "):
            every = {name for names in declared.values() for name in names}
            if override.name not in every:
                near = _nearest(override.name, every)
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
                near = _nearest(override.name, declared[node])
                lines.append(f"{override.where}: {node} has no parameter {override.name}{near}")
    return [*_missing(missing, declared), *dict.fromkeys(lines)]


def _missing(missing: dict[str, dict[str, str]], declared: Iterable[str]) -> Iterable[str]:
    """Return lines for the nodes of each file that are not here."""
    for file, nodes in missing.items():
        if len(nodes) > _FEW:
            first = ", ".join([*nodes][:_FEW])
            yield f"{file}: {len(nodes)} of its nodes are not here: {first} ..."
            continue
        for node, where in nodes.items():
            yield f"{where}: no node {node} here{_nearest(node, declared)}"


def _nearest(word: str, possible: Iterable[str]) -> str:
    found = difflib.get_close_matches(word, list(possible), n=1, cutoff=0.4)
    return f" (nearest: {found[0]})" if found else ""
