"""A YAML reader for text written by people, bounded in size and depth.

A file is read only if it is regular, UTF-8, at most 1 MB and nested at most 20 deep. Aliases are
refused, since a few of them can expand to gigabytes.
"""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import yaml

from archo_tui.base import regular_files
from archo_tui.base.regular_files import MAX_BYTES
from archo_tui.base.surrogates import has_lone_surrogate
from archo_tui.base.yaml_text.core_schema import FAST_LOADER, LOADER, YamlFault, value

T = TypeVar("T")

MAX_DEPTH = 20


class YamlError(ValueError):
    """An error in a YAML file; the message starts with `file:line:`, or with `file:`."""


def read(path: Path) -> str:
    """Return the text of a file, decoded from UTF-8; raise YamlError, or OSError."""
    try:
        data = regular_files.read(path)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EFBIG):
            raise
        raise YamlError(f"{path}: {error.strerror}") from None
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise YamlError(f"{path}:{line}: not UTF-8: save it as that") from None


def documents(text: str, path: Path) -> list[yaml.Node]:
    """Return the root node of each YAML document in a text; raise YamlError, naming `path`."""
    try:
        return _with_readable_error(text, _compose_all)
    except YamlFault as fault:
        raise YamlError(f"{path}:{fault.line}: {fault.reason}") from None


def compose(text: str, path: Path) -> yaml.Node | None:
    """Return the root node of a text with one document, None if empty; YamlError names `path`."""
    try:
        return node_of(text)
    except YamlFault as fault:
        raise YamlError(f"{path}:{fault.line}: {fault.reason}") from None


def load(text: str) -> Any:
    """Return the value of a text that somebody typed, or None if it is empty; raise YamlFault."""
    if len(text) > MAX_BYTES:
        raise YamlFault(1, f"more than {MAX_BYTES} characters")
    node = node_of(text)
    return None if node is None else value(node)


def scalar_texts(text: str) -> list[str]:
    """Return the elements of a YAML list of scalars as texts without quotes; raise YamlFault."""
    node = node_of(text)
    if not isinstance(node, yaml.SequenceNode):
        raise YamlFault(1, "not a list")
    for item in node.value:
        if not isinstance(item, yaml.ScalarNode):
            raise YamlFault(item.start_mark.line + 1, "not a list of single values")
    return [item.value for item in node.value]


def node_of(text: str) -> yaml.Node | None:
    """Return the root node of a text with one document, None if empty; raise YamlFault."""
    return _with_readable_error(text, _compose_one)


def _with_readable_error(text: str, compose_with: Callable[[str, Any], T]) -> T:
    """Return `compose_with(text, FAST_LOADER)`; take the error of LOADER, as a YamlFault."""
    try:
        return compose_with(text, FAST_LOADER)
    except YamlFault:
        raise
    except (yaml.YAMLError, ValueError):
        pass  # The Python loader reports it: its line numbers are the same on every machine.
    try:
        return compose_with(text, LOADER)
    except YamlFault:
        raise
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise YamlFault(mark.line + 1 if mark else 1, f"not YAML: {error.problem}") from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise YamlFault(line, f"not YAML: {str(error).splitlines()[0]}") from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # As for "\UFFFFFFFF", %YAML 9...9
        raise YamlFault(
            _last_readable_line(text), f"not YAML: {str(error).splitlines()[0]}"
        ) from None


def _last_readable_line(text: str) -> int:
    loader: Any = LOADER(text)
    with contextlib.suppress(ValueError, OverflowError, yaml.YAMLError):
        while loader.check_event():
            loader.get_event()
    return int(loader.line) + 1


def _compose_one(text: str, loader: Any) -> yaml.Node | None:
    _check_bounds(text, loader)
    node: yaml.Node | None = yaml.compose(text, Loader=loader)
    return node


def _compose_all(text: str, loader: Any) -> list[yaml.Node]:
    _check_bounds(text, loader)
    return list(yaml.compose_all(text, Loader=loader))


def _check_bounds(text: str, loader: Any) -> None:
    """Raise YamlFault for an alias, a lone surrogate, or deep nesting, by events alone."""
    depth = 0
    for event in yaml.parse(text, Loader=loader):
        line = event.start_mark.line + 1 if event.start_mark else 1
        if isinstance(event, yaml.AliasEvent):
            raise YamlFault(line, f"aliases (*{event.anchor}) are not read: write it out")
        if isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            depth += 1
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            depth -= 1
        elif isinstance(event, yaml.ScalarEvent) and has_lone_surrogate(event.value):
            raise YamlFault(line, "contains half of a surrogate pair")
        if depth > MAX_DEPTH:
            raise YamlFault(line, f"nested more than {MAX_DEPTH} deep")
