"""The command line after `--ros-args`: remapping, parameters, parameter files, log level."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rclpy._names import Remap, namespace_problem, node_name_problem, topic_problem
from rclpy._rclpy_pybind11 import RCLInvalidROSArgsError, UnknownROSArgsError

from archo_tui.base.yaml_text.bounded_yaml import YamlError
from archo_tui.ros.embedded.parameter_files import Override, matches, read, value_of

LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}

# Options of ROS without effect here, since there is no log file and no enclave.
_IGNORED_FLAGS = re.compile(r"--(enable|disable)-external-lib-logs|--enable-stdout-logs")


class Arguments(NamedTuple):
    """The ROS arguments of a command line; a `log_level` of 0 means that none is given."""

    remaps: tuple[Remap, ...] = ()
    overrides: tuple[Override, ...] = ()
    log_level: int = 0
    stdout_logs: bool = True
    rosout_logs: bool = True

    def parameters_of(self, node: str) -> dict[str, Any]:
        """Return the overrides for the node of that fully qualified name, by parameter name.

        As in rcl, the last value for a pattern wins, and of several patterns the one whose first
        value is named last. The value of an empty list is None, since it has no type.
        """
        by_pattern: dict[str, dict[str, Any]] = {}
        for override in self.overrides:
            by_pattern.setdefault(override.pattern, {})[override.name] = override.value
        found: dict[str, Any] = {}
        for pattern, values in by_pattern.items():
            if matches(pattern, node):
                # An empty list has no type: rcl takes the parameter as not set.
                found |= {name: None if v == [] else v for name, v in values.items()}
        return found


def parse(args: Sequence[str] | None) -> Arguments:
    """Parse the ROS arguments of a command line, and read the parameter files that it names."""
    remaps: list[Remap] = []
    overrides: list[Override] = []  # From files and single options, in their order.
    unknown: list[str] = []
    level, stdout_logs, rosout_logs = 0, True, True
    words = iter(split(args or ())[1])
    for word in words:
        if word in ("-r", "--remap"):
            remaps.append(_remap(_next(words, word)))
        elif word in ("-p", "--param"):
            overrides.append(_assignment(_next(words, word)))
        elif word == "--params-file":
            overrides.extend(_file(_next(words, word)))
        elif word == "--log-level":
            level = _level(_next(words, word))
        elif word == "--disable-stdout-logs":
            stdout_logs = False
        elif word in ("--disable-rosout-logs", "--enable-rosout-logs"):
            rosout_logs = word.startswith("--enable")
        elif not _IGNORED_FLAGS.fullmatch(word):
            unknown.append(word)
    if unknown:
        raise UnknownROSArgsError(str(unknown))
    return Arguments(tuple(remaps), tuple(overrides), level, stdout_logs, rosout_logs)


def split(args: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the program's own words, and the words behind `--ros-args` up to `--` or the end."""
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
        raise _invalid(f"{option} needs a value")
    return word


def _split(text: str, what: str) -> tuple[str | None, str, str]:
    """Split `[node:]left:=right` into its three parts; the node is None if it is left out."""
    left, sign, right = text.partition(":=")
    if not sign or not left:
        raise _invalid(f"{what} is not 'name:=value': {text!r}")
    node, colon, name = left.rpartition(":")
    return (node if colon else None), name, right


def _remap(text: str) -> Remap:
    rule = Remap(*_split(text, "remap rule"))
    if rule.match == "__ns":
        problem = namespace_problem(rule.replacement)
    elif rule.match in ("__node", "__name"):
        problem = node_name_problem(rule.replacement)
    else:
        problem = topic_problem(rule.match) or topic_problem(rule.replacement)
    if problem:
        raise _invalid(f"remap rule {text!r}: {problem}")
    return rule


def _assignment(text: str) -> Override:
    node, name, value = _split(text, "parameter")
    try:
        return Override(node or "/**", name, value_of(value), f"-p {text}")
    except ValueError as error:
        raise _invalid(f"parameter {name}: {error}") from None


def _file(text: str) -> list[Override]:
    try:
        return read(Path(text))
    except OSError as error:
        raise _invalid(f"cannot read {text}: {error.strerror}") from None
    except YamlError as error:
        raise _invalid(str(error)) from None


def _level(text: str) -> int:
    name = text.rpartition(":=")[2].lower()
    if name not in LEVELS:
        raise _invalid(f"no log level {text!r}: one of {', '.join(LEVELS)}")
    return LEVELS[name]


def _invalid(said: str) -> RCLInvalidROSArgsError:
    return RCLInvalidROSArgsError(f"Failed to parse ROS arguments: {said}")
