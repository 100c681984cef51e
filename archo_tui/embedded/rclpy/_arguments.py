"""`--ros-args`: remapping, parameters, parameter files, log level."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rclpy._names import Remap, validate_namespace, validate_node_name
from rclpy._rclpy_pybind11 import RCLError, RCLInvalidROSArgsError, UnknownROSArgsError
from rclpy.exceptions import NameValidationException

from archo_tui.embedded.bounded_yaml import YamlError
from archo_tui.embedded.parameter_files import Override, matches, read, value_of

LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}

# given by rclpy, without effect in one process: there is no log file and no enclave
_IGNORED_FLAGS = re.compile(r"--(enable|disable)-external-lib-logs|--enable-stdout-logs")


class Arguments(NamedTuple):
    """What a command line says to ROS."""

    remaps: tuple[Remap, ...] = ()
    overrides: tuple[Override, ...] = ()
    log_level: int = 0
    stdout_logs: bool = True
    rosout_logs: bool = True

    def parameters_of(self, node: str) -> dict[str, Any]:
        """Overrides for the node of that fully qualified name; the later one wins."""
        return {o.name: o.value for o in self.overrides if matches(o.pattern, node)}


def parse(args: Sequence[str] | None) -> Arguments:
    """Read what stands between `--ros-args` and `--`.

    Raises RCLInvalidROSArgsError, UnknownROSArgsError, and RCLError for a file that cannot be read.
    """
    remaps: list[Remap] = []
    files: list[Override] = []
    assigned: list[Override] = []
    level, stdout_logs, rosout_logs = 0, True, True
    words = iter(split(args or ())[1])
    for word in words:
        if word in ("-r", "--remap"):
            remaps.append(_remap(_next(words, word)))
        elif word in ("-p", "--param"):
            assigned.append(_assignment(_next(words, word)))
        elif word == "--params-file":
            files.extend(_file(_next(words, word)))
        elif word == "--log-level":
            level = _level(_next(words, word))
        elif word == "--disable-stdout-logs":
            stdout_logs = False
        elif word in ("--disable-rosout-logs", "--enable-rosout-logs"):
            rosout_logs = word.startswith("--enable")
        elif not _IGNORED_FLAGS.fullmatch(word):
            raise UnknownROSArgsError(f"unknown ROS argument: {word}")
    return Arguments(tuple(remaps), (*files, *assigned), level, stdout_logs, rosout_logs)


def split(args: Sequence[str]) -> tuple[list[str], list[str]]:
    """The program's own words, and those between `--ros-args` and `--`."""
    own: list[str] = []
    ros: list[str] = []
    inside = False
    for arg in args:
        if arg == "--ros-args":
            inside = True
        elif inside and arg == "--":
            inside = False
        else:
            (ros if inside else own).append(arg)
    return own, ros


def _next(words: Any, option: str) -> str:
    word: str | None = next(words, None)
    if word is None:
        raise RCLInvalidROSArgsError(f"{option} needs a value")
    return word


def _split(text: str, what: str) -> tuple[str | None, str, str]:
    """`[node:]left:=right` in its three parts."""
    left, sign, right = text.partition(":=")
    if not sign or not left:
        raise RCLInvalidROSArgsError(f"{what} is not 'name:=value': {text!r}")
    node, colon, name = left.rpartition(":")
    return (node if colon else None), name, right


def _remap(text: str) -> Remap:
    rule = Remap(*_split(text, "remap rule"))
    try:
        if rule.match == "__ns":
            validate_namespace(rule.replacement)
        elif rule.match in ("__node", "__name"):
            validate_node_name(rule.replacement)
    except NameValidationException as error:
        raise RCLInvalidROSArgsError(
            f"not a {error.name_type}: {error.name!r}: {error.error_msg}"
        ) from None
    return rule


def _assignment(text: str) -> Override:
    node, name, value = _split(text, "parameter")
    try:
        return Override(node or "/**", name, value_of(value), f"-p {text}")
    except ValueError as error:
        raise RCLInvalidROSArgsError(f"parameter {name}: {error}") from None


def _file(text: str) -> list[Override]:
    try:
        return read(Path(text))
    except OSError as error:
        raise RCLError(f"cannot read {text}: {error.strerror}") from None
    except YamlError as error:
        raise RCLError(str(error)) from None


def _level(text: str) -> int:
    name = text.rpartition(":=")[2].lower()
    if name not in LEVELS:
        raise RCLInvalidROSArgsError(f"no log level {text!r}: one of {', '.join(LEVELS)}")
    return LEVELS[name]
