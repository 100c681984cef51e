"""The command line of `archo-tui`, which imports rclpy and Textual only when it must."""

from __future__ import annotations

import argparse
import errno
import gc
import os
import signal
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from io import StringIO, TextIOBase, TextIOWrapper

from archo_tui import __version__
from archo_tui.collector import ShortPauses
from archo_tui.errors import ArchoError
from archo_tui.plain.lines import is_stop_text
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES, VERBS

TYPE_CHECKING = False  # Importing typing takes longer than everything that --help needs.
if TYPE_CHECKING:
    from typing import Any, NoReturn, TextIO

    from archo_tui.session import Session

FAILED, MISUSED = 1, 2  # Exit codes.
_AGAIN = 100  # shutdown.RESTART, which is not imported for --help.
_MOST_FAILURES = 3  # Crashes of the screen after which the program ends.


def _columns() -> int:
    """Return the width of the terminal or COLUMNS; 80 without a terminal."""
    said = os.environ.get("COLUMNS", "")
    if said.isdecimal() and int(said):
        return int(said)
    try:
        return os.get_terminal_size(1).columns or 80
    except OSError:
        return 80


class _Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line that says what is wrong, and where to look."""

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
        """Return `, nearest: --node` for the first option that is not known."""
        wrong = message.partition("unrecognized arguments: ")[2].split()
        typed = next((word.partition("=")[0] for word in wrong if word.startswith("--")), "")
        if not typed:
            return ""
        from archo_tui.nearest import nearest

        known = [option for action in self._actions for option in action.option_strings]
        near = nearest(typed, known)
        return f", nearest: {near}" if near else ""


class _Behind(argparse.Action):
    """An option of a verb that stands before it: kept as it was typed, to be put behind it."""

    def __call__(self, _: Any, options: Namespace, value: Any, option: str | None = None) -> None:
        given = [value] if isinstance(value, str) else []
        options.behind = [*options.behind, str(option), *given]


class _Formatter(argparse.HelpFormatter):
    """A help formatter that leaves indented lines of a text unchanged."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines = text.splitlines()
        fill = super()._fill_text
        return "\n".join(
            line if not line or line[0] == " " else fill(line, width, indent) for line in lines
        )


_DESCRIPTION = """\
Operate the warehouse robot ARCHO from a terminal.

examples:
  archo-tui                         ARCHO, without ROS
  archo-tui --engine ros2 --attach  a robot on ROS 2
  archo-tui go 12 --wait            a verb, from any shell

commands (archo-tui COMMAND --help says more):
"""


def parser(*, for_words: bool = True) -> argparse.ArgumentParser:
    """Return the parser of the console's options; ROS's own are taken off before.

    Args:
        for_words: True takes a command and the words behind it.
    """
    commands = "".join(f"  {name:<10} {what}\n" for name, (what, _, _) in SUBCOMMANDS.items())
    made = _Parser(
        "archo-tui",
        _DESCRIPTION + commands,
        usage="archo-tui [option ...]\n       archo-tui COMMAND ...\n       archo-tui VERB ...",
        epilog="A stop from here is a software stop: it does not replace the hardware one. "
        "What libraries print while the screen is shown goes to stderr.log, beside the journal.",
        add_help=False,  # it stands in the last group
    )
    if for_words:
        made.add_argument("command", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
        for name in (*VERB_VALUES, *VERB_FLAGS):
            nargs = 0 if name in VERB_FLAGS else None
            hidden = argparse.SUPPRESS
            made.add_argument(
                name, action=_Behind, nargs=nargs, dest="behind", default=[], help=hidden
            )
    made.add_argument_group(
        "verbs (archo-tui VERB --help says more)",
        f"{', '.join((*VERBS, 'wait'))}; a robot file adds its own; a console must run",
    )
    nodes = made.add_argument_group("your own nodes")
    nodes.add_argument(
        "--node",
        metavar="FILE",
        action="append",
        default=[],
        help="host the rclpy nodes that a Python file (or package.module) defines, in place of the "
        "robot's own of the same name, else beside them; they are restarted whenever the file is "
        "saved; can be given several times",
    )
    nodes.add_argument("--only", action="store_true", help="host none of the robot's own nodes")
    _interfaces_option(nodes, "; everything restarts when one is saved")
    robot = made.add_argument_group("the robot")
    robot.add_argument(
        "--use-sim", action="store_true", help="also start fake_battery_drain (2 %% a second)"
    )
    robot.add_argument(
        "--params-file",
        metavar="FILE",
        action="append",
        default=[],
        help="ROS parameter file for the nodes; can be given several times, the last one wins",
    )
    _robot_option(robot)
    ros = made.add_argument_group("ROS 2")
    _engine_option(ros)
    ros.add_argument(
        "--attach",
        action="store_true",
        help="host no nodes: operate the robot on the ROS 2 graph",
    )
    ros.add_argument(
        "--namespace", metavar="NS", default="/", help="namespace of the nodes (default: /)"
    )
    ros.add_argument(
        "--ros-args",
        metavar="...",
        help="ROS arguments for all nodes: -r from:=to, -p [node:]name:=value, --params-file FILE",
    )
    how = made.add_argument_group("how it is operated")
    how.add_argument(
        "--plain",
        action="store_true",
        help="no screen: commands on standard input (help lists them), an event a line on standard "
        "output; the exit code is 0 only when every goal arrived and every line succeeded",
    )
    how.add_argument(
        "--watch", action="store_true", help="show everything and send no command, not even STOP"
    )
    how.add_argument(
        "--no-remote",
        action="store_true",
        help="no socket: no other program reaches this console (archo-tui VERB, connect())",
    )
    how.add_argument(
        "--record",
        metavar="PATH",
        help="record everything that is heard, until the end, as a ROS bag there; every ten "
        "minutes another one is begun, with a number behind its name",
    )
    how.add_argument(
        "--recordings-limit",
        metavar="MB",
        type=_megabytes,
        default=1000,
        help="what all recordings may take; then the oldest are deleted (default: 1000)",
    )
    how.add_argument(
        "--quiet-alarms",
        action="store_true",
        help="no bell and no desktop notice for new alarms",
    )
    how.add_argument(
        "--on-disconnect",
        choices=("cancel", "leave"),
        default="cancel",
        help="what happens to a running goal when the terminal is lost or a signal ends the "
        "console: cancel it (default), or, with --attach, leave it running",
    )
    about = made.add_argument_group("about")
    about.add_argument("-h", "--help", action="help", help="show this help message and exit")
    about.add_argument(
        "--version",
        action="store_true",
        help="print the versions, the engine and TERM, for reports",
    )
    return made


def _megabytes(text: str) -> int:
    """Return a number of megabytes for recordings, 1 to a million."""
    if not text.isdecimal() or not 1 <= int(text[:9]) <= 1_000_000 or len(text) > 7:
        raise argparse.ArgumentTypeError(f"{text} is not 1 to 1000000 MB")
    return int(text)


def _engine_option(made: argparse._ActionsContainer) -> None:
    made.add_argument(
        "--engine",
        default="embedded",
        help="what `import rclpy` means: embedded (default, no ROS needed) or ros2 (the real one)",
    )


def _interfaces_option(made: argparse._ActionsContainer, then: str = "") -> None:
    made.add_argument(
        "--interfaces",
        metavar="DIR",
        action="append",
        default=[],
        help="an interface package, or a workspace's src/, whose files are taken before the "
        f"built-in ones{then}; may be repeated (embedded engine only)",
    )


def _robot_option(made: argparse._ActionsContainer) -> None:
    made.add_argument(
        "--robot",
        metavar="FILE",
        help="what the robot offers and what it means, instead of ARCHO's config/robots/archo.yaml",
    )


def _check_options(made: argparse._ActionsContainer) -> None:
    made.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="a Python file (or package.module) of rclpy nodes; it prints a line per check "
        "(TAP), with a hint where one fails",
    )
    _engine_option(made)
    _interfaces_option(made)


def _consoles_options(made: argparse._ActionsContainer) -> None:
    made.add_argument("--json", action="store_true", help="print one JSON object per line")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program.

    Args:
        argv: The words of the command line; None means the program's own.

    Returns:
        The exit code: 0; 1 if the console failed; 2 for a user's mistake; one of docs/shell.md
        for a verb; 128 and the number of the signal that ended the console.
    """
    if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Until heed_signals there is nothing to undo.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # None if it is closed.
            stream.reconfigure(errors="backslashreplace")
    given = sys.argv[1:] if argv is None else argv
    words, ros_args = split_ros_args(given)
    try:
        with ShortPauses():
            code = _obey(words, ros_args)
        if code == _AGAIN:
            os.execv(sys.executable, [sys.executable, *_itself(), *given])
        if sys.stdout is not None:
            sys.stdout.flush()
    except ArchoError as error:
        _complain(str(error))
        return MISUSED
    except OSError as error:
        closed = isinstance(sys.stdout, _Closed)
        written = error.errno in (errno.ENOSPC, errno.EPIPE, errno.EIO) or closed
        if not written or sys.stdout is None:
            raise
        if not closed:  # Python flushes once more at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        # A reader that ends early, such as `head`, needs no message.
        if error.errno != errno.EPIPE:
            _complain(f"cannot write to standard output: {error.strerror}")
        return FAILED
    finally:
        if isinstance(sys.stdout, _Closed):
            sys.stdout = None
        gc.enable()
        if signal.getsignal(signal.SIGINT) == signal.SIG_DFL:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    return code


class _Closed(TextIOBase):
    """A stand-in for a closed standard output, in which Python would lose what is printed."""

    def write(self, text: str) -> int:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF))


def _no_loss() -> None:
    """Make it an error from here on if something cannot be printed."""
    if sys.stdout is None:
        sys.stdout = _Closed()


def _itself() -> list[str]:
    """Return the arguments with which Python runs this program: a zip file, or the module."""
    from zipfile import is_zipfile

    return [sys.argv[0]] if is_zipfile(sys.argv[0]) else ["-m", "archo_tui"]


def _obey(words: list[str], ros_args: list[str]) -> int:
    """Run the subcommand that is named, else the console."""
    if words[:1] == ["help"]:  # No further word is passed on: a `stop` would stop.
        words = [*words[1:2], "--help"]
    is_verb = words and words[0][:1] != "-" and words[0] not in SUBCOMMANDS
    if is_verb or is_stop_text(" ".join(words)):
        from archo_tui.remote import shell  # Runs quickly, since a prompt may call it.

        _no_loss()
        return shell.run(words, SUBCOMMANDS)
    try:
        options = parser().parse_args(words)
        if options.behind and not options.command:
            raise ArchoError(f"{options.behind[0]} is for a verb: archo-tui VERB --help says which")
    except ArchoError as error:
        at = next((number for number, word in enumerate(words) if is_stop_text(word)), None)
        if at is None:
            raise
        from archo_tui.remote import shell

        _no_loss()
        _complain(f"{error}: STOP is sent anyway")
        return shell.run(words[at:], SUBCOMMANDS)
    if not options.command:
        return _run(options, ros_args)
    name, *rest = options.command
    if name != "mcp":  # mcp uses standard output for its protocol.
        _no_loss()
    if name not in SUBCOMMANDS:
        return _speak(options, words)
    what, add_options, run = SUBCOMMANDS[name]
    made = _Parser(f"archo-tui {name}", f"{what[0].upper()}{what[1:]}.")
    add_options(made)
    # Some of the console's options are the subcommand's too.
    before = words[: -len(options.command)]
    if ros_args:
        raise ArchoError(f"--ros-args is for the console, not for {name}")
    return run(made.parse_intermixed_args([*before, *rest]))


def _speak(options: Namespace, words: Sequence[str]) -> int:
    """Send a verb that stands after options of the console.

    Of these only `--engine` and `--namespace` matter: they say where a console is looked for. On
    ROS 2, where the verb needs no console, `--robot` matters as well.
    """
    from pathlib import Path

    from archo_tui.remote.shell import run

    own = ("robot",) if options.engine == "ros2" else ()

    plain = parser().parse_args([])
    given = [
        name.replace("_", "-")
        for name, value in vars(options).items()
        if name not in ("command", "behind", "namespace", "engine", *own)
        and value != getattr(plain, name)
    ]
    typed = [*options.command, *options.behind]
    made = parser()
    made.set_defaults(engine="", namespace="")
    said = made.parse_args(words)  # Only what was typed, without defaults.
    meant = {"engine": said.engine, "to": said.namespace}
    wrong = f"--{given[0]} is for the console, not for {typed[0]}" if given else ""
    if options.engine not in ("embedded", "ros2"):
        wrong = f"--engine {options.engine}: there are embedded and ros2"
        meant["engine"] = ""
    if wrong and not is_stop_text(typed[0]):
        raise ArchoError(wrong)
    if wrong:
        _complain(f"{wrong}: STOP is sent anyway")
    if options.engine != "ros2":
        return run(typed, SUBCOMMANDS, meant=meant)
    from archo_tui.remote.without_console import attached
    from archo_tui.session import Options, Session

    robot = Path(options.robot) if options.robot else None
    there = Options(engine="ros2", namespace=options.namespace, attach=True, robot=robot)
    attach = lambda: attached(lambda: Session(there))  # noqa: E731
    return run(typed, SUBCOMMANDS, attach, {**meant, "domain": _domain()}, robot)


def _domain() -> int:
    """Return the ROS 2 domain of this process; ROS 2 itself refuses what is no number."""
    said = os.environ.get("ROS_DOMAIN_ID", "").strip()
    return int(said) if said.isdecimal() else 0


def _completions_options(made: argparse._ActionsContainer) -> None:
    made.add_argument("shell", choices=("bash", "zsh", "fish"), help="for which shell")


def _completions(options: Namespace) -> int:
    """Print what a shell needs to complete our words; of the verbs those of ARCHO."""
    import shtab

    from archo_tui.remote.verb_help import options_of, verbs_of_file

    made = parser(for_words=False)
    commands = made.add_subparsers(metavar="COMMAND", parser_class=_Parser)
    for name, (what, add_options, _) in SUBCOMMANDS.items():
        add_options(commands.add_parser(name, help=what, description=what))
    told = {verb.id: (verb.help, verb.options) for verb in verbs_of_file().values()}
    told["wait"] = "Wait until it is so", ()
    for name, (what, takes) in told.items():
        one = commands.add_parser(name, help=what, description=what)
        for option, _ in options_of(name, takes):
            one.add_argument(*option.split()[:1], action="store_true")
    for action in made._actions:
        if action.metavar in ("FILE", "DIR", "PATH"):
            action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(made, shell=options.shell))
    return 0


def _recordings_options(made: argparse._ActionsContainer) -> None:
    made.add_argument("--json", action="store_true", help="print one JSON object per line")
    made.add_argument("--delete", metavar="NAME", nargs="+", default=[], help="delete these")


def _recordings(options: Namespace) -> int:
    """List or delete the recordings of the black box."""
    from archo_tui.recording.listing import delete_named, list_recordings

    if options.delete:
        for said in delete_named(options.delete):
            print(_safe(said))
        return 0
    for line in list_recordings(as_json=options.json):
        print(_safe(line))
    return 0


def _replay_options(made: argparse._ActionsContainer) -> None:
    made.add_argument(
        "recording",
        metavar="RECORDING",
        nargs="?",
        default="",
        help="its name, or the path of a ROS bag (MCAP); the newest recording when none is given",
    )
    made.add_argument("--text", action="store_true", help="print what happened, line by line")
    _robot_option(made)
    _interfaces_option(made)


def _replay(options: Namespace) -> int:
    """Show a recording on the screen, or as text."""
    from pathlib import Path

    from archo_tui import engine
    from archo_tui.hosting import own_interfaces

    if not options.text:
        try:
            _need_terminal(sys.stdin)
        except ArchoError as error:  # Without a terminal a replay offers --text.
            raise ArchoError(str(error).replace("--plain", "--text")) from None
    given = [Path(folder) for folder in options.interfaces]
    own, mistakes = own_interfaces.find_all(given, "embedded")
    for line in mistakes:
        _complain(f"not read: {line}")
    engine.activate("embedded", own=own)
    from archo_tui.clock import Clock
    from archo_tui.replay.resolve import load_robot_file, open_bag

    bag = open_bag(options.recording)
    robot = load_robot_file(bag, options.robot)
    if options.text:
        from archo_tui.replay.report import report_lines

        for line in report_lines(bag, robot):
            print(_safe(line))
        return 0
    from archo_tui.commands import keymap, registry
    from archo_tui.imports import OF_THE_SCREEN, import_the_rest
    from archo_tui.paths import config_file
    from archo_tui.replay.player import Player
    from archo_tui.replay.recorded_station import RecordedStation
    from archo_tui.replay_app import ReplayApp
    from archo_tui.shutdown import heed_signals
    from archo_tui.terminal import themes
    from archo_tui.terminal.stderr import guarded_stderr, log_file

    keys, _ = keymap.load_keymap(config_file("keymap.yaml"), registry(robot))
    heed_signals()
    import_the_rest(OF_THE_SCREEN)
    clock = Clock()
    station = RecordedStation(Player(bag, robot, clock), clock)
    app = ReplayApp(station, keys, themes.remembered_theme())
    with guarded_stderr(log_file()):
        app.run()
    if app.failure:
        _complain(f"the screen crashed: {app.failure.strip().splitlines()[-1]}")
    return app.return_code or 0


def _consoles(options: Namespace) -> int:
    """List the consoles that can be reached."""
    from archo_tui.remote.shell import consoles

    return consoles(["--json"] if options.json else [])


def _mcp_options(made: argparse._ActionsContainer) -> None:
    made.add_argument(
        "--allow",
        choices=("goals",),
        help="also let it ask for goals, each of which a person at the console allows or denies; "
        "else it can look and STOP, and nothing more",
    )
    made.add_argument(
        "--to",
        metavar="CONSOLE",
        default="",
        help="the process or the namespace of the console, where several run here",
    )


def _mcp(options: Namespace) -> int:
    """Serve an assistant on standard input and output."""
    try:
        from archo_tui.assistant.server import serve
    except ImportError:  # The SDK is missing or too old.
        said = "mcp needs another package: pip install '.[mcp]' in a clone of archo-tui"
        raise ArchoError(said) from None
    if sys.stdin is None or sys.stdout is None:
        raise ArchoError("mcp needs a standard input and output, and one is closed")
    if sys.stdin.isatty():
        _complain("mcp is started by an assistant's program, which speaks on standard input")
    serve(goals=options.allow == "goals", to=options.to)
    return 0


def _complain(said: str) -> None:
    """Print a line on standard error, if that is open."""
    if sys.stderr is not None:
        print(f"archo-tui: {_safe(said)}", file=sys.stderr)


def _safe(text: str) -> str:
    """Return one line on which no terminal acts."""
    if text.isascii() and text.isprintable():
        return text
    # It imports Rich, which takes most of the time of a short command.
    from archo_tui.robot.text import safe

    return safe(text)


def split_ros_args(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the words that are ours, and those between `--ros-args` and `--`."""
    own: list[str] = []
    ros: list[str] = []
    inside = False
    for word in words:
        if word in ("--ros-args", "--") and inside != (word == "--ros-args"):
            inside = not inside
        else:
            (ros if inside else own).append(word)
    return own, ros


def _keys(options: Namespace) -> int:
    """Print the current keymap, in the form of its file."""
    from pathlib import Path

    from archo_tui.commands import keymap, registry
    from archo_tui.paths import config_file
    from archo_tui.robot_file import load

    path = config_file("keymap.yaml")
    robot = load.load(Path(options.robot) if options.robot else load.default_path())
    commands = registry(robot)
    keys, others = keymap.load_keymap(path, commands)
    print(_safe(f"# {path}"))
    for command in commands:
        key, place = keys[command.id], command.where_text
        line = f"{command.id}: {key}" if key else f"# {command.id}:"
        if not key:
            place = "in the palette only"
            taker = keymap.key_owner(command, command.key, keys, commands)
            place += f", {command.key} is the key of {taker}" if taker else ""
        print(_safe(f"{line:<{len(command.id) + 18}} # {place}: {command.help}"))
    if others:
        _complain(others)
    return 0


def _version(engine: str) -> int:
    """Print what a bug report should say."""
    python, term = sys.version.split()[0], os.environ.get("TERM", "not set")
    print(f"archo-tui {__version__}")
    print(_safe(f"Python {python}, Textual {_textual_version()}, engine {engine}, TERM {term}"))
    return 0


def _textual_version() -> str:
    """Return Textual's version, by the name of the folder that its installation left.

    importlib.metadata reads the same there, and takes longer to load than all the rest.
    """
    for folder in sys.path:
        try:
            names = os.listdir(folder or ".")
        except OSError:
            continue
        for name in names:
            if name.startswith("textual-") and name.endswith(".dist-info"):
                return name.removeprefix("textual-").removesuffix(".dist-info")
    return "not installed by its package"


def _run(options: Namespace, ros_args: list[str]) -> int:
    if options.version:
        return _version(options.engine)
    from pathlib import Path

    if options.node:
        # With Python's 5 ms a callback that never waits would delay the drawing after a key.
        sys.setswitchinterval(0.0002)
    gc.disable()  # Everything made at the start stays; TerminalApp enables it again.
    from archo_tui.hosting.node_output import HarmlessOutput
    from archo_tui.session import Options, Session
    from archo_tui.shutdown import ignore_signals

    if options.plain and sys.stdout is None:
        raise ArchoError("--plain needs a standard output, and it is closed")
    stdin, sys.stdin = sys.stdin, StringIO()  # A node that asks for input gets none.
    if sys.stderr is not None:
        sys.stderr = HarmlessOutput(sys.stderr)
    session = Session(
        Options(
            engine=options.engine,
            params_files=[*map(Path, options.params_file)],
            use_sim=options.use_sim,
            namespace=options.namespace,
            node_files=options.node,
            only=options.only,
            robot=Path(options.robot) if options.robot else None,
            interfaces=[Path(folder) for folder in options.interfaces],
            watch=options.watch,
            ros_args=ros_args,
            attach=options.attach,
            on_disconnect=options.on_disconnect,
            quiet_alarms=options.quiet_alarms,
            recordings_limit=options.recordings_limit * 1_000_000,
            record=Path(options.record) if options.record is not None else None,
            remote=not options.no_remote,
        )
    )
    stuck: list[str] = []
    try:
        is_plain = options.plain
        code = _plain(session, options, stdin) if is_plain else _console(session, stdin)
    finally:
        ignore_signals()
        stuck = session.close()
    if session.unrecorded:
        _complain(session.unrecorded)
    for name in stuck:
        _complain(f"{name} did not stop: its callback does not return")
    lost = options.record is not None and session.unrecorded  # Only --record makes it a failure.
    return code or (FAILED if stuck or lost else 0)


def _journal(_options: Namespace) -> int:
    """Print where the journal is."""
    from archo_tui.paths import journal_file

    print(_safe(str(journal_file())))
    return 0


def _check(options: Namespace) -> int:
    """Run the checks of the textbook's chapter."""
    from pathlib import Path

    from archo_tui.chapter.run import run

    signal.signal(signal.SIGINT, signal.default_int_handler)  # So that temporary files are removed.
    out = sys.stdout
    try:
        return run(
            options.files,
            options.engine,
            [Path(folder) for folder in options.interfaces],
            lambda line: print(line, file=out, flush=True),
        )
    except KeyboardInterrupt:
        _complain("interrupted: not all was checked")
        return FAILED


def _plain(session: Session, options: Namespace, stdin: TextIO | None) -> int:
    from archo_tui.hosting.node_output import NodeOutput
    from archo_tui.imports import OF_ALL, import_the_rest
    from archo_tui.plain import plain
    from archo_tui.shutdown import heed_signals

    if options.robot:  # Keys are not used here, but a wrong one is an error as elsewhere.
        from archo_tui.commands import keymap, registry

        keymap.default_keys(registry(session.file))
    heed_signals()
    sys.stdout.flush()  # Later a reader that stalls would block.
    sys.stdout = NodeOutput(sys.stdout, session.robot.note)
    session.start()
    import_the_rest(OF_ALL)
    gc.enable()
    # None if it is closed: its descriptor may belong to another file now.
    return plain.run(session.station, None if stdin is None else stdin.fileno())


def _console(session: Session, stdin: TextIO | None) -> int:
    _need_terminal(stdin)
    import asyncio

    from archo_tui.app import ArchoApp
    from archo_tui.commands import keymap, registry
    from archo_tui.paths import config_file
    from archo_tui.shutdown import heed_signals, let_go
    from archo_tui.terminal import themes
    from archo_tui.terminal.stderr import guarded_stderr, log_file

    station, clock = session.station, session.station.clock
    commands = registry(session.file)
    keys, others = keymap.load_keymap(config_file("keymap.yaml"), commands)
    heed_signals()
    session.start()
    if others:
        station.robot.note("WARN", "console", others)
    failed, failures = "", 0
    while True:
        app = ArchoApp(station, keys=keys, theme=themes.remembered_theme(), failed=failed)
        with guarded_stderr(log_file()):
            app.run()
        if not app.failure:
            return app.return_code or 0
        failed, failures = app.failure, failures + 1
        last = failed.strip().splitlines()[-1]
        station.robot.note("ERROR", "console", f"the screen crashed: {last}")
        session.journal.write(clock.now(), "screen failure", text=last, traceback=failed)
        if failures == _MOST_FAILURES:
            why = "the screen keeps crashing"
            asyncio.run(let_go(station.robot, clock, station.on_disconnect, why))
            _complain(f"the screen keeps crashing: {last}")
            return FAILED


# Variables for Textual's developers, which press keys or end the app, and a size that may not be
# the terminal's. A shell exports them to every program.
_FOREIGN = ("TEXTUAL_DRIVER", "TEXTUAL_PRESS", "TEXTUAL_SCREENSHOT", "COLUMNS", "LINES")


def _need_terminal(stdin: TextIO | None) -> None:
    """Raise ArchoError unless a screen can be shown; remove what would disturb it.

    Called before Textual is imported, which reads its settings once.
    """
    for name in _FOREIGN:
        os.environ.pop(name, None)
    term = os.environ.get("TERM", "")
    if term in ("", "dumb", "unknown"):
        said = f"TERM is {term}" if term else "TERM is not set"
        raise ArchoError(f"{said}: this terminal cannot show a screen, use --plain")
    streams = {"stdin": stdin, "stdout": sys.stdout}
    if sys.platform != "win32":  # Textual's driver for POSIX draws on standard error.
        streams["stderr"] = sys.__stderr__
    for name, stream in streams.items():
        if stream is None or not stream.isatty():  # None if it is closed.
            raise ArchoError(f"{name} is not a terminal: run archo-tui in one, or use --plain")
        if _device(stream) != _device(stdin or stream):
            raise ArchoError(f"{name} is another terminal than stdin: run archo-tui in one of them")


def _device(stream: TextIO) -> int:
    """Return the number of a terminal's device, since its name may not be known in a container."""
    if sys.platform == "win32":
        return 0
    return os.fstat(stream.fileno()).st_rdev


# Of each subcommand: its help, its options, and the function that runs it.
SUBCOMMANDS: dict[str, tuple[str, Callable[[_Parser], None], Callable[[Namespace], int]]] = {
    "check": ("ask nodes what the textbook's chapter asks", _check_options, _check),
    "keys": ("print every key, in the form of keymap.yaml", _robot_option, _keys),
    "completions": ("print the completions for a shell", _completions_options, _completions),
    "consoles": ("list the consoles that run here", _consoles_options, _consoles),
    "mcp": ("let an assistant ask at the console (MCP)", _mcp_options, _mcp),
    "recordings": ("list the recordings", _recordings_options, _recordings),
    "replay": ("play a recording back on the screen", _replay_options, _replay),
    "journal": ("print the path of the journal, in JSON lines", lambda _: None, _journal),
}
