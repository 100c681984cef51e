"""A verb from the command line, also one behind options of the console."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence

from archo_tui.base.nearest import nearest
from archo_tui.cli.options import ENGINES, SUBCOMMANDS, OneLineErrorParser
from archo_tui.client.shell import complain, run

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path
    from typing import Any

    from archo_tui.verbs.verb import Verb

_ROBOT_OPTIONS = ("--engine", "--namespace", "--robot")  # Options that say which robot is meant.


def send_verb(words: Sequence[str], options: Namespace) -> int:
    """Send a verb, and with `--engine ros2` to the robot itself if no console runs."""
    return _send(words, options, {"engine": options.engine, "to": options.namespace})


def wrong_option(verb: str, options: Namespace, parser: ArgumentParser) -> str:
    """Return why a verb cannot stand after the console's options that were typed, or "".

    Only `--engine` and `--namespace`, which say where a console is looked for, are allowed, and
    `--robot` with `--engine ros2`.
    """
    if options.engine and options.engine not in ENGINES:
        return f"--engine {options.engine}: there are {' and '.join(ENGINES)}"
    allowed = ["namespace", "engine", *(["robot"] if options.engine == "ros2" else [])]
    for action in parser._actions:
        name = action.dest
        if name not in allowed and getattr(options, name, action.default) != action.default:
            return f"{action.option_strings[0]} is for the console, not for {verb}"
    return ""


def send_stop(
    stop: Sequence[str], before: Sequence[str], wrong: str, parser: OneLineErrorParser
) -> int:
    """Send a STOP that stands behind wrong options, and print the result.

    A misspelt option counts as the nearest one that says which robot is meant, but only where no
    console confirms the STOP.
    """
    complain(f"{wrong}: trying to send STOP anyway")
    known = parser._option_string_actions
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

    if given.engine != "ros2":
        return run(typed, SUBCOMMANDS, meant=meant, helps=helps)
    from archo_tui.console.attached import attached
    from archo_tui.session.options import Options
    from archo_tui.session.session import Session

    robot = Path(given.robot) if given.robot else None  # Behind wrong options it is a text.
    there = Options(engine="ros2", namespace=given.namespace or "/", attach=True, robot=robot)
    attach = lambda: attached(lambda: Session(there))  # noqa: E731
    return run(typed, SUBCOMMANDS, attach, {**meant, "domain": _domain()}, lambda: helps(robot))


def _domain() -> int:
    """Return the ROS 2 domain of this process; 0 for no number, which ROS 2 itself refuses."""
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    return int(text) if text.isdecimal() else 0


def verbs_of_file(path: Path | None = None) -> dict[str, Verb]:
    """Return a robot's verbs by id; fields of goals count as int32, as no interface is read."""
    from archo_tui.robot.messages.types import TypedField
    from archo_tui.robot_file.load import default_path, load
    from archo_tui.verbs import verbs

    robot = load(path or default_path())
    return verbs(
        robot,
        {goal.id: [TypedField(path, "int32", 0) for path in goal.form] for goal in robot.goals},
    )


def helps(path: Path | None = None) -> dict[str, str]:
    """Return the help of each verb of a robot file, by what is typed. Raises ArchoError."""
    return {verb.id: verb.help_text for verb in verbs_of_file(path).values()}
