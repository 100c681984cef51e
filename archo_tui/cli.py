"""The command line of `archo-tui`. Imports neither rclpy nor Textual until it must."""

from __future__ import annotations

import argparse
import errno
import gc
import os
import signal
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from io import StringIO, TextIOWrapper

from archo_tui import __version__
from archo_tui.errors import ArchoError

TYPE_CHECKING = False  # without typing, which takes longer to load than all that --help needs
if TYPE_CHECKING:
    from typing import Any, NoReturn, TextIO

    from archo_tui.session import Session

FAILED, MISUSED = 1, 2  # exit codes
_AGAIN = 100  # shutdown.RESTART, which is not loaded for --help: begin again, with the same words
_MOST_FAILURES = 3  # of the screen, after which it is given up


def _columns() -> int:
    """The terminal's, unless COLUMNS says otherwise; 80 where there is none."""
    said = os.environ.get("COLUMNS", "")
    if said.isdecimal() and int(said):
        return int(said)
    try:
        return os.get_terminal_size(1).columns or 80
    except OSError:
        return 80


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong, and where to look."""

    def __init__(self, prog: str, description: str, **more: Any) -> None:
        width = _columns() - 2  # as argparse has it by itself, for which it loads all of shutil
        super().__init__(
            prog=prog,
            description=description,
            allow_abbrev=False,  # a typo is said, and not taken for something else
            formatter_class=lambda prog: _Formatter(prog, width=width),
            **more,
        )

    def error(self, message: str) -> NoReturn:
        raise ArchoError(f"{message} (see {self.prog} --help)")


class _Formatter(argparse.HelpFormatter):
    """Leaves indented lines of a text as they are."""

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
  archo-tui --node battery.py       a node of your own
  archo-tui --engine ros2 --attach  a robot on ROS 2

commands (archo-tui COMMAND --help says more):
"""


def parser() -> argparse.ArgumentParser:
    """The console's options; what follows --ros-args is ROS's and is taken off before."""
    commands = "".join(f"  {name:<10} {what}\n" for name, (what, _, _) in SUBCOMMANDS.items())
    made = _Parser(
        "archo-tui",
        _DESCRIPTION + commands,
        usage="archo-tui [option ...]\n       archo-tui COMMAND ...",
        epilog="A stop from here is a software stop: it does not replace the hardware one. "
        "What libraries print while the screen is shown goes to stderr.log, beside the journal.",
        add_help=False,  # it stands in the last group
    )
    made.add_argument("command", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
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
        "--quiet-alarms",
        action="store_true",
        help="no bell and no notice of the desktop for a new alarm",
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
        help="an interface package, or a workspace's src/, whose files are taken before the "
        f"built-in ones{then} (embedded engine only)",
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
        help="a Python file (or package.module) of rclpy nodes; what comes of it is a line a check "
        "(TAP), with a hint for what is wrong",
    )
    _engine_option(made)
    _interfaces_option(made)


def main(argv: Sequence[str] | None = None) -> int:
    """Run; returns the exit code: 0, 1 when the console failed, 2 for a user's mistake."""
    if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # until heed_signals nothing is to be undone
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # not where it is closed
            stream.reconfigure(errors="backslashreplace")
    given = sys.argv[1:] if argv is None else argv
    words, ros_args = split_ros_args(given)
    try:
        code = _obey(words, ros_args)
        if code == _AGAIN:
            os.execv(sys.executable, [sys.executable, "-m", "archo_tui", *given])
        if sys.stdout is not None:
            sys.stdout.flush()
    except ArchoError as error:
        _complain(str(error))
        return MISUSED
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EPIPE, errno.EIO) or sys.stdout is None:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes once more
        _complain(f"cannot write to standard output: {error.strerror}")
        return FAILED
    finally:
        gc.enable()
        if signal.getsignal(signal.SIGINT) == signal.SIG_DFL:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    return code


def _obey(words: list[str], ros_args: list[str]) -> int:
    """Run the subcommand that is named, else the console."""
    options = parser().parse_args(words)
    if not options.command:
        return _run(options, ros_args)
    name, *rest = options.command
    if name not in SUBCOMMANDS:
        import difflib

        near = difflib.get_close_matches(name, SUBCOMMANDS, n=1)
        hint = f" (nearest: {near[0]})" if near else ""
        raise ArchoError(f"no command {name!r}{hint}: one of {', '.join(SUBCOMMANDS)}")
    what, add_options, run = SUBCOMMANDS[name]
    made = _Parser(f"archo-tui {name}", f"{what[0].upper()}{what[1:]}.")
    add_options(made)
    before = words[: -len(options.command)]  # of the console's options, some are its own too
    if ros_args:
        raise ArchoError(f"--ros-args is for the console, not for {name}")
    return run(made.parse_intermixed_args([*before, *rest]))


def _complain(said: str) -> None:
    """One line on standard error, where that is open."""
    if sys.stderr is not None:
        print(f"archo-tui: {_safe(said)}", file=sys.stderr)


def _safe(text: str) -> str:
    """One line that no terminal acts on."""
    if text.isascii() and text.isprintable():
        return text
    from archo_tui.robot.text import safe  # and with it Rich, which is most of a short command

    return safe(text)


def split_ros_args(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """The words that are ours, and those between `--ros-args` and `--`."""
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
    """The current keymap, in the form of its file."""
    from pathlib import Path

    from archo_tui.commands import keymap, registry
    from archo_tui.paths import config_file
    from archo_tui.robots import load

    path = config_file("keymap.yaml")
    commands = registry(load.load(Path(options.robot) if options.robot else load.default()))
    keys, others = keymap.load(path, commands)
    print(_safe(f"# {path}"))
    for command in commands:
        key, place = keys[command.id], command.place
        line = f"{command.id}: {key}" if key else f"# {command.id}:"
        if not key:
            place = "in the palette only"
            taker = keymap.who_has(command, command.key, keys, commands)
            place += f", {command.key} is the key of {taker}" if taker else ""
        print(_safe(f"{line:<{len(command.id) + 18}} # {place}: {command.help}"))
    if others:
        _complain(others)
    return 0


def _version(engine: str) -> int:
    """What a report of an error should say."""
    python, term = sys.version.split()[0], os.environ.get("TERM", "not set")
    print(f"archo-tui {__version__}")
    print(_safe(f"Python {python}, Textual {_textual()}, engine {engine}, TERM {term}"))
    return 0


def _textual() -> str:
    """Its version, by the name of the folder that its installation left.

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
        # beside a callback that never waits, Python's 5 ms would pass many times between a key and
        # what it draws
        sys.setswitchinterval(0.0002)
    gc.disable()  # all that is imported and made at the start stays; TerminalApp enables it again
    from archo_tui.node_output import HarmlessOutput
    from archo_tui.session import Options, Session
    from archo_tui.shutdown import ignore_signals

    if options.plain and sys.stdout is None:
        raise ArchoError("--plain needs a standard output, and it is closed")
    stdin, sys.stdin = sys.stdin, StringIO()  # a node that asks for input gets none
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
            interfaces=Path(options.interfaces) if options.interfaces else None,
            watch=options.watch,
            ros_args=ros_args,
            attach=options.attach,
            on_disconnect=options.on_disconnect,
            quiet_alarms=options.quiet_alarms,
        )
    )
    stuck: list[str] = []
    try:
        is_plain = options.plain
        code = _plain(session, options, stdin) if is_plain else _console(session, stdin)
    finally:
        ignore_signals()
        stuck = session.close()
    for name in stuck:
        _complain(f"{name} did not stop: its callback does not return")
    return code or (FAILED if stuck else 0)


def _journal(_options: Namespace) -> int:
    """Where it is."""
    from archo_tui.paths import journal_file

    print(_safe(str(journal_file())))
    return 0


def _check(options: Namespace) -> int:
    """What the chapter asks, asked."""
    from pathlib import Path

    from archo_tui.check import run

    signal.signal(signal.SIGINT, signal.default_int_handler)  # what it makes is to go
    out = sys.stdout
    try:
        return run(
            options.files,
            options.engine,
            Path(options.interfaces) if options.interfaces else None,
            lambda line: print(line, file=out, flush=True),
        )
    except KeyboardInterrupt:
        _complain("interrupted: not all was checked")
        return FAILED


def _plain(session: Session, options: Namespace, stdin: TextIO | None) -> int:
    from archo_tui import plain
    from archo_tui.node_output import NodeOutput
    from archo_tui.shutdown import heed_signals

    if options.robot:  # its keys are not used here, and no more wrong than elsewhere
        from archo_tui.commands import keymap, registry

        keymap.robots_keys(registry(session.description))
    heed_signals()
    sys.stdout.flush()  # later it would wait for a reader that stalls
    sys.stdout = NodeOutput(sys.stdout, session.robot.note)
    session.start()
    gc.enable()
    # None where it is closed: its descriptor may have become another file's
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
    keys, others = keymap.load(config_file("keymap.yaml"), registry(session.description))
    heed_signals()
    session.start()
    if others:
        station.robot.note("WARN", "console", others)
    failed, failures = "", 0
    while True:
        app = ArchoApp(station, keys=keys, theme=themes.remembered(), failed=failed)
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


def _need_terminal(stdin: TextIO | None) -> None:
    if os.environ.get("TEXTUAL_DRIVER"):  # another driver than a terminal's
        return
    term = os.environ.get("TERM", "")
    if term in ("", "dumb", "unknown"):
        said = f"TERM is {term}" if term else "TERM is not set"
        raise ArchoError(f"{said}: this terminal cannot show a screen, use --plain")
    streams = {"stdin": stdin, "stdout": sys.stdout}
    if sys.platform != "win32":  # Textual's driver of POSIX draws on it
        streams["stderr"] = sys.__stderr__
    for name, stream in streams.items():
        if stream is None or not stream.isatty():  # None: it is closed
            raise ArchoError(f"{name} is not a terminal: run archo-tui in one, or use --plain")
        if _device(stream) != _device(stdin or stream):
            raise ArchoError(f"{name} is another terminal than stdin: run archo-tui in one of them")


def _device(stream: TextIO) -> int:
    """Which terminal it is: its name may not be known in a container."""
    if sys.platform == "win32":
        return 0
    return os.fstat(stream.fileno()).st_rdev


# what it does, its options, and what runs it
SUBCOMMANDS: dict[str, tuple[str, Callable[[_Parser], None], Callable[[Namespace], int]]] = {
    "check": ("ask nodes what the textbook's chapter asks", _check_options, _check),
    "keys": ("print every key, in the form of keymap.yaml", _robot_option, _keys),
    "journal": ("print the path of the journal, in JSON lines", lambda _: None, _journal),
}
