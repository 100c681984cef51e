"""Reads YAML that a person wrote, and nothing that would hang or exhaust the process.

Of a regular file, in UTF-8, at most 1 MB, nested at most 20 deep, without aliases.
"""

from __future__ import annotations

import contextlib
import errno
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import yaml

from archo_tui import regular_files
from archo_tui.embedded.core_schema import FAST_LOADER, LOADER, YamlFault, value
from archo_tui.regular_files import MAX_BYTES

T = TypeVar("T")

MAX_DEPTH = 20
_HALF = re.compile("[\ud800-\udfff]")  # no text has them alone, nor can be written with them


class YamlError(ValueError):
    """Why a file is not read; the message starts with `file:line:`, or with `file:`."""


def read(path: Path) -> str:
    """The text of a file. Raises YamlError, and OSError as `open` does."""
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
    """Return the node tree of each document of a text. Raises YamlError."""
    try:
        return _tried(text, _all_composed)
    except YamlFault as fault:
        raise YamlError(f"{path}:{fault.line}: {fault.said}") from None


def compose(text: str, path: Path) -> yaml.Node | None:
    """The node tree of a text, None when it is empty. Raises YamlError."""
    try:
        return node_of(text)
    except YamlFault as fault:
        raise YamlError(f"{path}:{fault.line}: {fault.said}") from None


def load(text: str) -> Any:
    """What a text that was typed says, None when it is empty. Raises YamlFault."""
    if len(text) > MAX_BYTES:
        raise YamlFault(1, f"more than {MAX_BYTES} characters")
    node = node_of(text)
    return None if node is None else value(node)


def texts(text: str) -> list[str]:
    """The elements of a list of single values as they were typed: their type says what they mean.

    Raises YamlFault.
    """
    node = node_of(text)
    if not isinstance(node, yaml.SequenceNode):
        raise YamlFault(1, "not a list")
    for item in node.value:
        if not isinstance(item, yaml.ScalarNode):
            raise YamlFault(item.start_mark.line + 1, "not a list of single values")
    return [item.value for item in node.value]


def node_of(text: str) -> yaml.Node | None:
    """The node tree of a text, None when it is empty. Raises YamlFault."""
    return _tried(text, _composed)


def _tried(text: str, composed: Callable[[str, Any], T]) -> T:
    """Return what a text is composed to. Raises YamlFault."""
    try:
        return composed(text, FAST_LOADER)
    except YamlFault:
        raise
    except (yaml.YAMLError, ValueError):
        pass  # said by the other one, whose lines are the same on every machine
    try:
        return composed(text, LOADER)
    except YamlFault:
        raise
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise YamlFault(mark.line + 1 if mark else 1, f"not YAML: {error.problem}") from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise YamlFault(line, f"not YAML: {str(error).splitlines()[0]}") from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # "\UFFFFFFFF", %YAML 9...9
        raise YamlFault(_reached(text), f"not YAML: {str(error).splitlines()[0]}") from None


def _reached(text: str) -> int:
    """The line up to which a text can be read."""
    loader: Any = LOADER(text)
    with contextlib.suppress(ValueError, OverflowError, yaml.YAMLError):
        while loader.check_event():
            loader.get_event()
    return int(loader.line) + 1


def _composed(text: str, loader: Any) -> yaml.Node | None:
    _check(text, loader)
    node: yaml.Node | None = yaml.compose(text, Loader=loader)
    return node


def _all_composed(text: str, loader: Any) -> list[yaml.Node]:
    _check(text, loader)
    return list(yaml.compose_all(text, Loader=loader))


def _check(text: str, loader: Any) -> None:
    """Look at the events, which costs no more than the text is long."""
    depth = 0
    for event in yaml.parse(text, Loader=loader):
        line = event.start_mark.line + 1 if event.start_mark else 1
        if isinstance(event, yaml.AliasEvent):
            raise YamlFault(line, f"aliases (*{event.anchor}) are not read: write it out")
        if isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            depth += 1
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            depth -= 1
        elif isinstance(event, yaml.ScalarEvent) and _HALF.search(event.value):
            raise YamlFault(line, "contains half of a surrogate pair")
        if depth > MAX_DEPTH:
            raise YamlFault(line, f"nested more than {MAX_DEPTH} deep")
