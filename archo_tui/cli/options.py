"""The options of the console and of each subcommand, and the parser whose errors are one line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

from archo_tui.base.errors import ArchoError
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES, VERBS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

ENGINES = ("embedded", "ros2")

_DESCRIPTION = """\
Operate the warehouse robot ARCHO from a terminal.

examples:
  archo-tui                         ARCHO, without ROS
  archo-tui --engine ros2 --attach  a robot on ROS 2
  archo-tui go 12 --wait            a verb, from any shell

commands (archo-tui COMMAND --help says more):
"""


def _megabytes(text: str) -> int:
    """Return the bytes for the text of `--recordings-limit`, 1 to a million MB."""
    if not text.isdecimal() or not 1 <= int(text[:9]) <= 1_000_000 or len(text) > 7:
        raise argparse.ArgumentTypeError(f"{text} is not 1 to 1000000 MB")
    return int(text) * 1_000_000


def _flag(text: str, **more: Any) -> dict[str, Any]:
    return {"action": "store_true", "help": text, **more}


def _value(metavar: str, text: str, **more: Any) -> dict[str, Any]:
    return {"metavar": metavar, "help": text, **more}


def _values(metavar: str, text: str, **more: Any) -> dict[str, Any]:
    return _value(metavar, text, action="append", default=[], **more)


# All arguments by their names; those of the console are called as in `session.options.Options`.
_ARGUMENTS: dict[str, dict[str, Any]] = {
    "--node": _values(
        "FILE",
        "run a Python file (or package.module) as `python FILE` does, with its main(), beside the "
        "console; its nodes replace the robot's own of the same names; it restarts when it is "
        "saved; can be given several times. Words behind -- are arguments of the last one",
        dest="node_files",
    ),
    "--only": _flag("host only the nodes of --node, not the robot's own"),
    "--interfaces": _values(
        "DIR",
        "use the files of an interface package, or of a workspace's src/, before the built-in "
        "ones; a console restarts when one is saved; can be given several times (embedded engine "
        "only)",
        type=Path,
    ),
    "--use-sim": _flag("also start fake_battery_drain (2 %% a second)"),
    "--params-file": _values(
        "FILE",
        "ROS parameter file for the nodes; can be given several times, the last one wins",
        dest="params_files",
        type=Path,
    ),
    "--robot": _value(
        "FILE",
        "robot file: what the robot offers and what it means (default: ARCHO's, "
        "config/robots/archo.yaml)",
        type=Path,
    ),
    "--engine": {
        "default": "",  # A verb goes to any console if none is typed.
        "help": "what `import rclpy` imports: embedded (default, needs no ROS) or ros2 (the "
        "installed ROS 2, which alone `robot` looks at)",
    },
    "--attach": _flag("operate the robot on the ROS 2 graph, and host no nodes"),
    "--namespace": _value("NS", "namespace of the nodes (default: /)", default=""),
    "--ros-args": _value(
        "...",
        "ROS arguments for all nodes: --params-file FILE, -r from:=to, -p [node:]name:=value",
    ),
    "--plain": _flag(
        "operate without a screen: read commands from standard input (help lists them), print one "
        "event per line; the exit code is 0 only when every goal arrived and every line succeeded"
    ),
    "--watch": _flag("show everything but send no command, not even STOP"),
    "--no-remote": _flag(
        "open no socket: other programs (archo-tui VERB, connect()) do not reach this console",
        action="store_false",
        dest="remote",
    ),
    "--record": _value(
        "PATH",
        "record all messages as a ROS bag at PATH, until the end; every ten minutes a new bag "
        "begins, with a number behind its name",
        type=Path,
    ),
    "--recordings-limit": _value(
        "MB",
        "disk space for all recordings; beyond it the oldest are deleted (default: 1000)",
        type=_megabytes,
        default=1_000_000_000,
    ),
    "--quiet-alarms": _flag("ring no bell for new alarms"),
    "--on-disconnect": {
        "choices": ("cancel", "leave"),
        "default": "cancel",
        "help": "what the console does with a running goal when the terminal is lost or a signal "
        "ends the console: cancel it (default), or, with --attach, leave it running",
    },
    "--version": _flag("print the versions, the engine and TERM, for reports"),
    # Of subcommands.
    "folder": _value(
        "DIR",
        "the workspace that is written (chapter if it is left out); never over a file",
        nargs="?",
        default="chapter",
    ),
    "files": _value(
        "FILE",
        "Python file (or package.module) with rclpy nodes; each check prints one line (TAP), and a "
        "hint if it fails",
        nargs="+",
    ),
    "file": _value(
        "FILE",
        "launch file (NAME.launch.py, .xml or .yaml), or a workspace that has one",
        type=Path,
    ),
    "arguments": _value(
        "NAME:=VALUE", "value of an argument that the launch file declares", nargs="*"
    ),
    "--show-args": _flag("print the arguments of the file, and run nothing"),
    "shell": {"choices": ("bash", "zsh", "fish"), "help": "for which shell"},
    "--json": _flag("print one JSON object per line"),
    "--delete": _value("NAME", "delete the recordings so named", nargs="+", default=[]),
    "recording": _value(
        "RECORDING",
        "name of a recording, or path of a ROS bag (MCAP); default: the newest recording",
        nargs="?",
        default="",
    ),
    "--text": _flag("print what happened, line by line"),
    "--out": _value("FILE", "write the robot file there; else it is printed", type=Path),
    "--allow": {
        "choices": ("goals",),
        "help": "the assistant may also ask for goals; a person at the console allows or denies "
        "each one. Without this it can only read and send STOP",
    },
    "--to": _value(
        "CONSOLE",
        "process number or namespace of the console, where several run",
        default="",
    ),
}
_OPERATION = (
    *("--plain", "--watch", "--no-remote", "--record", "--recordings-limit", "--quiet-alarms"),
    "--on-disconnect",
)
_GROUPS = {
    "your own nodes": ("--node", "--only", "--interfaces"),
    "the robot": ("--use-sim", "--params-file", "--robot"),
    "ROS 2": ("--engine", "--attach", "--namespace", "--ros-args"),
    "the console": _OPERATION,
}
# The help and the arguments of each subcommand; `cli.__init__` has the function that runs it.
SUBCOMMANDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "chapter": ("write the chapter's files to start from", ("folder",)),
    "check": ("check nodes as the textbook's chapter asks", ("files", "--engine", "--interfaces")),
    "launch": (
        "run a ROS 2 launch file, without ROS",
        ("file", "arguments", "--show-args", "--engine", "--interfaces", "--robot", *_OPERATION),
    ),
    "keys": ("print all keys, in the form of keymap.yaml", ("--robot",)),
    "completions": ("print the completion script of a shell", ("shell",)),
    "consoles": ("list the consoles that run here", ("--json",)),
    "mcp": ("connect an assistant to the console (MCP)", ("--allow", "--to")),
    "recordings": ("list or delete the recordings", ("--json", "--delete")),
    "look": ("look for nodes in the ROS 2 domains 0 to 20", ()),
    "robot": ("write a robot file for what is on the graph", ("--out", "--namespace", "--engine")),
    "replay": (
        "play a recording back on the screen",
        ("recording", "--text", "--robot", "--interfaces"),
    ),
    "journal": ("print the path of the journal (JSON lines)", ()),
}


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
    parser.set_defaults(arguments=())  # `--node FILE -- ARG ...`
    parser.add_argument_group(
        "verbs (archo-tui VERB --help says more)",
        f"{', '.join(VERBS)}; a robot file adds its own. A verb is sent to the console "
        "that is running.",
    )
    for title, names in _GROUPS.items():
        _add(parser.add_argument_group(title), names)
    about = parser.add_argument_group("about")
    about.add_argument("-h", "--help", action="help", help="show this help message and exit")
    _add(about, ["--version"])
    return parser


def add_subcommand_arguments(parser: argparse.ArgumentParser, name: str) -> None:
    """Add the arguments of a subcommand to its parser."""
    _add(parser, SUBCOMMANDS[name][1])


def _add(parser: argparse._ActionsContainer, names: Sequence[str]) -> None:
    for name in names:
        parser.add_argument(name, **_ARGUMENTS[name])


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
        super().__init__(
            prog=prog,
            description=description,
            allow_abbrev=False,  # A typo is an error, and not another option.
            formatter_class=_Formatter,
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
        from archo_tui.base.nearest import nearest

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
