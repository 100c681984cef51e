"""A verb that is typed behind options of the console, such as `archo-tui --engine ros2 go 12`."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence

from archo_tui.cli.options import ENGINES, SUBCOMMANDS
from archo_tui.cli.output import complain
from archo_tui.cli.verb_help import helps
from archo_tui.errors import ArchoError
from archo_tui.nearest import nearest
from archo_tui.robot.stop.words import is_stop_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_ROBOT_OPTIONS = ("--engine", "--namespace", "--robot")  # Options that say which robot is meant.


def send_verb(options: Namespace, parser: ArgumentParser, words: Sequence[str]) -> int:
    """Send a verb that stands after options of the console, and print its result.

    Only `--engine` and `--namespace`, which say where a console is looked for, are allowed, and
    `--robot` with `--engine ros2`: if no console runs, the verb goes to the robot itself. Other
    options raise ArchoError, but a STOP is sent all the same.
    """
    typed = [*options.command, *options.verb_options]
    wrong = _wrong_option(options, parser)
    if wrong and is_stop_text(typed[0]):
        return send_stop(typed, words[: -len(options.command)], wrong, parser)
    if wrong:
        raise ArchoError(wrong)
    return _send(typed, options, {"engine": options.engine, "to": options.namespace})


def _wrong_option(options: Namespace, parser: ArgumentParser) -> str:
    """Return why a verb cannot stand after the options that were typed, or ""."""
    if options.engine and options.engine not in ENGINES:
        return f"--engine {options.engine}: there are {' and '.join(ENGINES)}"
    allowed = ["command", "verb_options", "namespace", "engine"]
    if options.engine == "ros2":
        allowed.append("robot")
    for name, value in vars(options).items():
        if name not in allowed and value != parser.get_default(name):
            option = name.replace("_", "-")
            return f"--{option} is for the console, not for {options.command[0]}"
    return ""


def send_stop(
    stop: Sequence[str], before: Sequence[str], wrong: str, parser: ArgumentParser
) -> int:
    """Send a STOP that stands behind wrong options, and print the result.

    A misspelt option counts as the nearest one that says which robot is meant, but only where no
    console confirms the STOP.
    """
    complain(f"{wrong}: trying to send STOP anyway")
    known = [option for action in parser._actions for option in action.option_strings]
    corrected = []
    for word in before:
        name, equals, value = word.partition("=")
        near = nearest(name, _ROBOT_OPTIONS) if name[:2] == "--" and name not in known else ""
        corrected.append(f"{near}{equals}{value}" if near else word)
    lenient = ArgumentParser(add_help=False, allow_abbrev=False)
    for option in _ROBOT_OPTIONS:
        lenient.add_argument(option, nargs="?", default="")
    typed, given = (lenient.parse_known_args(words)[0] for words in (before, corrected))
    given.engine = nearest(given.engine or "", ENGINES)
    engine = typed.engine if typed.engine in ENGINES else ""
    return _send(stop, given, {"engine": engine, "to": typed.namespace})


def _send(typed: Sequence[str], given: Namespace, meant: Mapping[str, Any]) -> int:
    """Send a verb to a console, and with `--engine ros2` to the robot itself if none runs."""
    from pathlib import Path

    from archo_tui.client.shell import run

    if given.engine != "ros2":
        return run(typed, SUBCOMMANDS, meant=meant, helps=helps)
    from archo_tui.console.attached import attached
    from archo_tui.session import Session
    from archo_tui.session_options import Options

    robot = Path(given.robot) if given.robot else None
    there = Options(engine="ros2", namespace=given.namespace or "/", attach=True, robot=robot)
    attach = lambda: attached(lambda: Session(there))  # noqa: E731
    return run(typed, SUBCOMMANDS, attach, {**meant, "domain": _domain()}, lambda: helps(robot))


def _domain() -> int:
    """Return the ROS 2 domain of this process; 0 for no number, which ROS 2 itself refuses."""
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    return int(text) if text.isdecimal() else 0
