"""A verb that is typed behind options of the console, such as `archo-tui --engine ros2 go 12`."""

from __future__ import annotations

import os
from argparse import Namespace
from collections.abc import Sequence

from archo_tui.cli.options import SUBCOMMANDS, console_parser
from archo_tui.cli.output import complain
from archo_tui.cli.verb_help import helps
from archo_tui.errors import ArchoError
from archo_tui.robot.stop.words import is_stop_text


def send_verb(options: Namespace, words: Sequence[str]) -> int:
    """Send a verb that stands after options of the console, and print its result.

    Only `--engine` and `--namespace`, which say where a console is looked for, are allowed, and
    `--robot` with `--engine ros2`: if no console runs, the verb goes to the robot itself. Other
    options raise ArchoError, but a STOP is sent all the same.
    """
    from pathlib import Path

    from archo_tui.client.shell import run

    typed = [*options.command, *options.verb_options]
    of_the_console = _options_of_the_console(options)
    parser = console_parser()
    parser.set_defaults(engine="", namespace="")
    without_defaults = parser.parse_args(words)
    meant = {"engine": without_defaults.engine, "to": without_defaults.namespace}
    wrong = (
        f"--{of_the_console[0]} is for the console, not for {typed[0]}" if of_the_console else ""
    )
    if options.engine not in ("embedded", "ros2"):
        wrong = f"--engine {options.engine}: there are embedded and ros2"
        meant["engine"] = ""
    if wrong and not is_stop_text(typed[0]):
        raise ArchoError(wrong)
    if wrong:
        complain(f"{wrong}: STOP is sent anyway")
    if options.engine != "ros2":
        return run(typed, SUBCOMMANDS, meant=meant, helps=helps)
    from archo_tui.console.attached import attached
    from archo_tui.session import Session
    from archo_tui.session_options import Options

    robot = Path(options.robot) if options.robot else None
    there = Options(engine="ros2", namespace=options.namespace, attach=True, robot=robot)
    attach = lambda: attached(lambda: Session(there))  # noqa: E731
    return run(typed, SUBCOMMANDS, attach, {**meant, "domain": _domain()}, lambda: helps(robot))


def _options_of_the_console(options: Namespace) -> list[str]:
    """Return the names of given options that are not their defaults and not a verb's."""
    allowed = ["command", "verb_options", "namespace", "engine"]
    if options.engine == "ros2":
        allowed.append("robot")
    defaults = console_parser().parse_args([])
    return [
        name.replace("_", "-")
        for name, value in vars(options).items()
        if name not in allowed and value != getattr(defaults, name)
    ]


def _domain() -> int:
    """Return the ROS 2 domain of this process; 0 for no number, which ROS 2 itself refuses."""
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    return int(text) if text.isdecimal() else 0
