"""Reads YAML that a person wrote, and nothing that would hang or exhaust the process.

Of a regular file, in UTF-8, at most 1 MB, nested at most 20 deep, without aliases.
"""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path
from typing import Any

import yaml

_FAST: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # in C where PyYAML was built with it
MAX_BYTES = 1_000_000
MAX_DEPTH = 20


class YamlError(ValueError):
    """Why a file is not read; the message starts with `file:line:`, or with `file:`."""


def read(path: Path) -> str:
    """The text of a file. Raises YamlError, and OSError as `open` does."""
    if not stat.S_ISREG(os.stat(path).st_mode):  # a pipe that nobody fills would block
        raise YamlError(f"{path}: not a regular file")
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise YamlError(f"{path}: larger than {MAX_BYTES // 1_000_000} MB")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise YamlError(f"{path}:{line}: not UTF-8: save it as that") from None


def compose(text: str, path: Path) -> yaml.Node | None:
    """The node tree of a text, None when it is empty. Raises YamlError."""
    try:
        return _composed(text, path, _FAST)
    except yaml.YAMLError:
        pass  # said by the other one, whose lines are the same on every machine
    try:
        return _composed(text, path, yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else 1
        raise YamlError(f"{path}:{line}: not YAML: {error.problem}") from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise YamlError(f"{path}:{line}: not YAML: {str(error).splitlines()[0]}") from None
    except (ValueError, OverflowError) as error:  # PyYAML's own: "\UFFFFFFFF", %YAML 9...9
        raise YamlError(f"{path}:{_reached(text)}: not YAML: {error}") from None


def _reached(text: str) -> int:
    """The line up to which a text can be read."""
    loader: Any = yaml.SafeLoader(text)
    with contextlib.suppress(ValueError, OverflowError):
        while loader.check_event():
            loader.get_event()
    return int(loader.line) + 1


def _composed(text: str, path: Path, loader: Any) -> yaml.Node | None:
    _check(text, path, loader)
    node: yaml.Node | None = yaml.compose(text, Loader=loader)
    return node


def _check(text: str, path: Path, loader: Any) -> None:
    """Look at the events, which costs no more than the text is long."""
    depth = 0
    for event in yaml.parse(text, Loader=loader):
        line = event.start_mark.line + 1 if event.start_mark else 1
        if isinstance(event, yaml.AliasEvent):
            raise YamlError(f"{path}:{line}: aliases (*{event.anchor}) are not read: write it out")
        if isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            depth += 1
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            depth -= 1
        if depth > MAX_DEPTH:
            raise YamlError(f"{path}:{line}: nested more than {MAX_DEPTH} deep")
