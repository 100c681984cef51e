"""The options of the console and of each subcommand, and the parser whose errors are one line."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from itertools import islice

from archo_tui.errors import ArchoError
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES, VERBS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

COMPLETE = "__complete"  # The hidden command of completion scripts; cobra's has the same name.
ENGINES = ("embedded", "ros2")

_DESCRIPTION = """\
Operate the warehouse robot ARCHO from a terminal.

examples:
  archo-tui                         ARCHO, without ROS
  archo-tui --engine ros2 --attach  a robot on ROS 2
  archo-tui go 12 --wait            a verb, from any shell

commands (archo-tui COMMAND --help says more):
"""


def console_parser() -> OneLineErrorParser:
    """Return the parser of the console's options, for words without ROS's own."""
    commands = "".join(f"  {name:<12} {what}\n" for name, (what, _) in SUBCOMMANDS.items())
    parser = OneLineErrorParser(
        "archo-tui",
        _DESCRIPTION + commands,
        usage="archo-tui [option ...]\n       archo-tui COMMAND ...\n       archo-tui VERB ...",
        epilog="STOP is a software stop: it does not replace the robot's hardware stop. "
        "While the screen is shown, what libraries print goes to stderr.log, beside the journal.",
        add_help=False,  # it stands in the last group
    )
    parser.set_defaults(program_arguments=())  # `--node FILE -- ARG ...`
    parser.add_argument_group(
        "verbs (archo-tui VERB --help says more)",
        f"{', '.join((*VERBS, 'wait'))}; a robot file adds its own. A verb is sent to the console "
        "that is running.",
    )
    _node_options(parser.add_argument_group("your own nodes"))
    _robot_options(parser.add_argument_group("the robot"))
    _ros_options(parser.add_argument_group("ROS 2"))
    _operation_options(parser.add_argument_group("the console"))
    _about_options(parser.add_argument_group("about"))
    return parser


def split_line(words: Sequence[str], parser: OneLineErrorParser) -> tuple[list[str], list[str]]:
    """Split a line into options of the console, and a subcommand or verb with all words behind it.

    Options of a verb that stand before it are put behind it; without a verb they stand alone.
    """
    actions = parser._option_string_actions
    takes_value = {*VERB_VALUES, *(name for name, each in actions.items() if each.nargs is None)}
    console: list[str] = []
    of_verb: list[str] = []
    remaining = iter(words)
    for word in remaining:
        name, equals, _ = word.partition("=")
        if word[:1] != "-":
            return console, [word, *remaining, *of_verb]
        group = of_verb if name in (*VERB_VALUES, *VERB_FLAGS) else console
        group.append(word)
        if name in takes_value and not equals:
            group += islice(remaining, 1)
    return console, of_verb


def _node_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--node",
        metavar="FILE",
        action="append",
        default=[],
        help="run a Python file (or package.module) as `python FILE` does, with its main(), beside "
        "the console; its nodes replace the robot's own of the same names; it restarts when it is "
        "saved; can be given several times. Words behind -- are arguments of the last one",
    )
    # Its older name, until the next release.
    group.add_argument("--run", dest="node", action="append", help=argparse.SUPPRESS)
    group.add_argument(
        "--only",
        action="store_true",
        help="host only the nodes of --node, not the robot's own",
    )
    _interfaces_option(group, "; when one is saved, everything restarts")


def _robot_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--use-sim",
        action="store_true",
        help="also start fake_battery_drain (2 %% a second)",
    )
    group.add_argument(
        "--params-file",
        metavar="FILE",
        action="append",
        default=[],
        help="ROS parameter file for the nodes; can be given several times, the last one wins",
    )
    _robot_option(group)


def _ros_options(group: argparse._ArgumentGroup) -> None:
    _engine_option(group, default="")  # A verb goes to any console if none is typed.
    group.add_argument(
        "--attach",
        action="store_true",
        help="operate the robot on the ROS 2 graph, and host no nodes",
    )
    _namespace_option(group, default="")
    group.add_argument(
        "--ros-args",
        metavar="...",
        help="ROS arguments for all nodes: --params-file FILE, -r from:=to, -p [node:]name:=value",
    )


def _operation_options(group: argparse._ActionsContainer) -> None:
    group.add_argument(
        "--plain",
        action="store_true",
        help="operate without a screen: read commands from standard input (help lists them), print "
        "one event per line; the exit code is 0 only when every goal arrived and every line "
        "succeeded",
    )
    group.add_argument(
        "--watch", action="store_true", help="show everything but send no command, not even STOP"
    )
    group.add_argument(
        "--no-remote",
        action="store_true",
        help="open no socket: other programs (archo-tui VERB, connect()) do not reach this console",
    )
    group.add_argument(
        "--record",
        metavar="PATH",
        help="record all messages as a ROS bag at PATH, until the end; every ten minutes a new bag "
        "begins, with a number behind its name",
    )
    group.add_argument(
        "--recordings-limit",
        metavar="MB",
        type=_megabytes,
        default=1000,
        help="disk space for all recordings; beyond it the oldest are deleted (default: 1000)",
    )
    group.add_argument(
        "--quiet-alarms",
        action="store_true",
        help="ring no bell for new alarms",
    )
    group.add_argument(
        "--on-disconnect",
        choices=("cancel", "leave"),
        default="cancel",
        help="what the console does with a running goal when the terminal is lost or a signal ends "
        "the console: cancel it (default), or, with --attach, leave it running",
    )


def _about_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument("-h", "--help", action="help", help="show this help message and exit")
    group.add_argument(
        "--version",
        action="store_true",
        help="print the versions, the engine and TERM, for reports",
    )


def _megabytes(text: str) -> int:
    """Return the number in the text of `--recordings-limit`, 1 to a million."""
    if not text.isdecimal() or not 1 <= int(text[:9]) <= 1_000_000 or len(text) > 7:
        raise argparse.ArgumentTypeError(f"{text} is not 1 to 1000000 MB")
    return int(text)


def _engine_option(parser: argparse._ActionsContainer, default: str = "embedded") -> None:
    parser.add_argument(
        "--engine",
        default=default,
        help="what `import rclpy` imports: embedded (default, needs no ROS) or ros2 (the installed "
        "ROS 2)",
    )


def _namespace_option(parser: argparse._ActionsContainer, default: str = "/") -> None:
    parser.add_argument(
        "--namespace", metavar="NS", default=default, help="namespace of the nodes (default: /)"
    )


def _interfaces_option(parser: argparse._ActionsContainer, then: str = "") -> None:
    parser.add_argument(
        "--interfaces",
        metavar="DIR",
        action="append",
        default=[],
        help="use the files of an interface package, or of a workspace's src/, before the built-in "
        f"ones{then}; can be given several times (embedded engine only)",
    )


def _robot_option(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--robot",
        metavar="FILE",
        help="robot file: what the robot offers and what it means (default: ARCHO's, "
        "config/robots/archo.yaml)",
    )


def _chapter_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "folder",
        metavar="DIR",
        nargs="?",
        default="chapter",
        help="the workspace that is written (chapter if it is left out); never over a file",
    )


def _check_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="Python file (or package.module) with rclpy nodes; each check prints one line (TAP), "
        "and a hint if it fails",
    )
    _engine_option(parser)
    _interfaces_option(parser)


def _describe_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--out", metavar="FILE", help="write the robot file there; else it is printed"
    )
    _namespace_option(parser)
    parser.add_argument("--engine", default="ros2", help=argparse.SUPPRESS)


def _launch_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "file",
        metavar="FILE",
        help="launch file (NAME.launch.py, .xml or .yaml), or a workspace that has one",
    )
    parser.add_argument(
        "arguments",
        metavar="NAME:=VALUE",
        nargs="*",
        help="value of an argument that the launch file declares",
    )
    parser.add_argument(
        "--show-args", action="store_true", help="print the arguments of the file, and run nothing"
    )
    _engine_option(parser)
    _interfaces_option(parser, "; when one is saved, everything restarts")
    _robot_option(parser)
    _operation_options(parser)


def _completions_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument("shell", choices=("bash", "zsh", "fish"), help="for which shell")


def _consoles_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")


def _recordings_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")
    parser.add_argument(
        "--delete",
        metavar="NAME",
        nargs="+",
        default=[],
        help="delete the recordings so named",
    )


def _replay_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "recording",
        metavar="RECORDING",
        nargs="?",
        default="",
        help="name of a recording, or path of a ROS bag (MCAP); default: the newest recording",
    )
    parser.add_argument("--text", action="store_true", help="print what happened, line by line")
    _robot_option(parser)
    _interfaces_option(parser)


def _mcp_options(parser: argparse._ActionsContainer) -> None:
    parser.add_argument(
        "--allow",
        choices=("goals",),
        help="the assistant may also ask for goals; a person at the console allows or denies each "
        "one. Without this it can only read and send STOP",
    )
    parser.add_argument(
        "--to",
        metavar="CONSOLE",
        default="",
        help="process number or namespace of the console, where several run",
    )


def split_ros_args(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the words for this program, and those between `--ros-args` and `--` or the end."""
    own: list[str] = []
    ros: list[str] = []
    inside = False
    for word in words:
        if word in ("--ros-args", "--") and inside != (word == "--ros-args"):
            inside = not inside
        else:
            (ros if inside else own).append(word)
    return own, ros


class OneLineErrorParser(argparse.ArgumentParser):
    """An argument parser that raises an ArchoError of one line where others print and exit."""

    def __init__(self, prog: str, description: str, **more: Any) -> None:
        width = _columns() - 2  # As in argparse, which imports all of shutil for it.
        super().__init__(
            prog=prog,
            description=description,
            allow_abbrev=False,  # A typo is an error, and not another option.
            formatter_class=lambda prog: _Formatter(prog, width=width),
            **more,
        )

    def error(self, message: str) -> NoReturn:
        raise ArchoError(f"{message}{self._nearest(message)} (see {self.prog} --help)")

    def _nearest(self, message: str) -> str:
        """Return `, nearest: --node` for the first option that an error calls unknown, or ""."""
        wrong = message.partition("unrecognized arguments: ")[2].split()
        typed = next((word.partition("=")[0] for word in wrong if word.startswith("--")), "")
        if not typed:
            return ""
        from archo_tui.nearest import nearest

        known = [option for action in self._actions for option in action.option_strings]
        near = nearest(typed, known)
        return f", nearest: {near}" if near else ""


class _Formatter(argparse.HelpFormatter):
    """A help formatter that leaves indented lines of a text unchanged."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines = text.splitlines()
        fill = super()._fill_text
        return "\n".join(
            line if not line or line[0] == " " else fill(line, width, indent) for line in lines
        )


def _columns() -> int:
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and int(columns):
        return int(columns)
    try:
        return os.get_terminal_size(1).columns or 80
    except OSError:
        return 80


# The help and the options of each subcommand; `cli.__init__` has the function that runs it.
SUBCOMMANDS: dict[str, tuple[str, Callable[[OneLineErrorParser], None]]] = {
    "chapter": ("write the chapter's files to start from", _chapter_options),
    "check": ("check nodes as the textbook's chapter asks", _check_options),
    "launch": ("run a ROS 2 launch file, without ROS", _launch_options),
    "keys": ("print all keys, in the form of keymap.yaml", _robot_option),
    "completions": ("print the completion script of a shell", _completions_options),
    "consoles": ("list the consoles that run here", _consoles_options),
    "mcp": ("connect an assistant to the console (MCP)", _mcp_options),
    "recordings": ("list or delete the recordings", _recordings_options),
    "look": ("look for nodes in the ROS 2 domains 0 to 20", lambda _: None),
    "robot": ("write a robot file for what is on the graph", _describe_options),
    "replay": ("play a recording back on the screen", _replay_options),
    "journal": ("print the path of the journal (JSON lines)", lambda _: None),
}
