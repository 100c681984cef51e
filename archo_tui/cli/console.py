"""The run of a console, with a screen or with `--plain`, from its options to its exit code."""

from __future__ import annotations

import gc
import os
import sys
from argparse import Namespace
from functools import partial
from io import StringIO

from archo_tui import __version__
from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import safe
from archo_tui.cli.options import ENGINES
from archo_tui.client.protocol import FAILED
from archo_tui.client.shell import complain

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TextIO

    from archo_tui.base.handover import Handover
    from archo_tui.screen.app import ArchoApp
    from archo_tui.session.options import Launch
    from archo_tui.session.session import Session

# Crashes of the screen in a row after which the program ends. One that a person's key led to can be
# avoided by that person, and must not end a console that drives.
_MOST_FAILURES = 3
# Variables for Textual's developers, which press keys or end the app, and a size that may not be
# the terminal's. A shell exports them to every program.
_FOREIGN = ("TEXTUAL_DRIVER", "TEXTUAL_PRESS", "TEXTUAL_SCREENSHOT", "COLUMNS", "LINES")


def run_console(options: Namespace, ros_args: list[str], launch: Launch | None = None) -> int:
    """Run a console until it is left, and return its exit code; RESTART to start again.

    The standard input and error of this process are replaced, so that a node cannot read keys or
    write escape sequences. Signals are ignored at the end.
    """
    options.engine, options.namespace = options.engine or ENGINES[0], options.namespace or "/"
    if options.version:
        return _print_version(options.engine)
    from archo_tui.base.handover import restore_terminal, take
    from archo_tui.station.shutdown import RESTART

    left, code = take(), FAILED
    try:
        code = _run(options, ros_args, launch, left)
    finally:
        if left is not None and code != RESTART:  # It may not have come to its screen.
            restore_terminal(left.terminal)
    return code


def _run(
    options: Namespace, ros_args: list[str], launch: Launch | None, left: Handover | None
) -> int:
    """Do what `run_console` does, with what the process before a restart has left."""
    if options.node_files or launch:
        # With Python's 5 ms a callback that never waits would delay the drawing after a key.
        sys.setswitchinterval(0.0002)
    gc.disable()  # Everything made at the start stays; TerminalApp enables it again.
    from archo_tui.session.options import Options
    from archo_tui.session.session import Session
    from archo_tui.station.shutdown import RESTART, ignore_signals
    from archo_tui.user_code.output import HarmlessOutput

    if options.plain and sys.stdout is None:
        raise ArchoError("--plain needs a standard output, and it is closed")
    stdin, sys.stdin = sys.stdin, StringIO()  # A node that asks for input gets none.
    if sys.stderr is not None:
        sys.stderr = HarmlessOutput(sys.stderr)
    given = {name: value for name, value in vars(options).items() if name in Options._fields}
    given |= {
        "ros_args": ros_args,
        "launch": launch,
        "handover": _with_typed_stop(left, stdin),
        "stop_was_typed": partial(_is_stop_typed, left, stdin),
    }
    session = Session(Options(**given))
    stuck: list[str] = []
    code = FAILED
    try:
        is_plain = options.plain
        code = _run_plain(session, options, stdin) if is_plain else _run_screen(session, stdin)
    finally:
        ignore_signals()
        stuck = session.close(restarts=code == RESTART)
    if code == RESTART:
        _restart(session, stdin)
    if session.unrecorded:
        complain(session.unrecorded)
    for name in stuck:
        complain(f"{name} did not stop: its callback does not return")
    lost = options.record is not None and session.unrecorded  # Only --record makes it a failure.
    return code or (FAILED if stuck or lost else 0)


def _typed(stdin: TextIO | None, stop_key: str) -> set[str]:
    """Drop what was typed while no screen read it; return Textual's names of the keys."""
    if sys.platform != "win32" and stdin is not None:
        from archo_tui.screen.terminal.driver import drain_keys

        return drain_keys(stdin.fileno(), stop_key)
    return set()


def _is_stop_typed(left: Handover | None, stdin: TextIO | None) -> bool:
    """Return True if a STOP was typed since the last look; False but after a restart."""
    return left is not None and left.stop_key in _typed(stdin, left.stop_key)


def _with_typed_stop(left: Handover | None, stdin: TextIO | None) -> Handover | None:
    """Return the record of the process before with a STOP that was typed since."""
    if left is None:
        return None
    return left._replace(stop=left.stop or _is_stop_typed(left, stdin))


def _restart(session: Session, stdin: TextIO | None) -> None:
    """Leave the record for the next process, with a STOP that was typed."""
    from archo_tui.base.handover import give

    left = _with_typed_stop(session.hand_over(), stdin)
    assert left is not None
    give(left)


def _run_plain(session: Session, options: Namespace, stdin: TextIO | None) -> int:
    """Take commands line by line from `stdin` until its end; what nodes print becomes events."""
    from archo_tui.base.imports import OF_ALL, import_the_rest
    from archo_tui.console import plain
    from archo_tui.station.shutdown import heed_signals, nothing_published_while_suspended
    from archo_tui.user_code.output import NodeOutput

    if options.robot:  # Keys are not used here, but a wrong one is an error as elsewhere.
        from archo_tui.screen.commands import keymap, registry

        keymap.default_keys(registry(session.file))
    heed_signals()
    sys.stdout.flush()  # Later a reader that stalls would block.
    sys.stdout = NodeOutput(sys.stdout, session.robot.note)
    session.start()
    import_the_rest(OF_ALL)
    gc.enable()
    # None if it is closed: its descriptor may belong to another file now.
    with nothing_published_while_suspended(session.robot):
        return plain.run(session.station, None if stdin is None else stdin.fileno())


def _run_screen(session: Session, stdin: TextIO | None) -> int:
    """Start the session and show the screen until it is left; after a crash, show it again.

    What is typed meanwhile is for the next screen. After the third crash without a key between
    them, the running goal is cancelled or left, as `--on-disconnect` says, and FAILED is returned.
    """
    require_terminal(stdin)
    import asyncio

    from archo_tui.base.handover import Handover, restore_terminal
    from archo_tui.base.paths import config_file
    from archo_tui.screen.app import ArchoApp
    from archo_tui.screen.commands import keymap, registry
    from archo_tui.screen.terminal import themes
    from archo_tui.screen.terminal.stderr import guarded_streams, log_file
    from archo_tui.station.shutdown import RESTART, heed_signals

    station, clock = session.station, session.station.clock
    left = session.options.handover
    commands = registry(session.file)
    keys, others = keymap.load_keymap(config_file("keymap.yaml"), commands)
    heed_signals()
    session.start()
    if others:
        station.robot.note("WARN", "console", others)
    failed, failures = "", 0
    if _is_stop_typed(left, stdin):
        station.robot.stops.register()
        session.send_stop("the console restarted")
    settings_before = None if left is None else left.terminal
    try:
        while True:
            app = ArchoApp(station, keys=keys, theme=themes.remembered_theme(), failed=failed)
            app.settings_before, app.is_followed = settings_before, True
            with guarded_streams(log_file(), session.printer_of_children()):
                app.run()
            settings_before = app.settings_before
            if not app.failure:
                if app.return_code == RESTART:
                    why, key = station.waiting_restart, app.shown_keys["stop"]
                    restart = Handover(why, stop_key=app.stop_key, terminal=settings_before)
                    session.restart = restart
                    complain(f"{why}: the console restarts; {key} is STOP meanwhile")
                else:  # It may have ended while its terminal was lent.
                    restore_terminal(settings_before)
                return app.return_code or 0
            failed, failures = app.failure, 1 if app.was_operated else failures + 1
            last = failed.strip().splitlines()[-1]
            station.robot.note("ERROR", "console", f"the screen crashed: {last}")
            session.journal.write(clock.now(), "screen failure", text=last, traceback=failed)
            if failures == _MOST_FAILURES:
                asyncio.run(_give_up(app, stdin))
                restore_terminal(settings_before)
                complain(f"the screen keeps crashing: {last}")
                return FAILED
            if not station.robot.stops.are_answered:  # Who sent it, or was to, is gone.
                session.send_stop("the screen crashed")
    except BaseException:  # A crash has left the terminal to the next screen, which never came.
        restore_terminal(settings_before)
        raise


async def _give_up(app: ArchoApp, stdin: TextIO | None) -> None:
    """Send a STOP that was typed since the last screen, and cancel or leave the running goal."""
    from archo_tui.station.shutdown import CANCEL, let_go

    station, stops = app.station, app.stops
    typed = _typed(stdin, app.stop_key)
    if app.stop_key in typed:
        stops.register()
    if not stops.are_answered:
        await station.robot.emergency_stop()
    choice = CANCEL if app.keys["cancel"] in typed else station.on_disconnect
    await let_go(station.robot, station.clock, choice, "the screen keeps crashing")
    if app.stop_key in _typed(stdin, app.stop_key):
        stops.register()
        await station.robot.emergency_stop()


def _print_version(engine: str) -> int:
    from importlib.metadata import version

    python, term = sys.version.split()[0], os.environ.get("TERM", "not set")
    print(f"archo-tui {__version__}")
    print(safe(f"Python {python}, Textual {version('textual')}, engine {engine}, TERM {term}"))
    return 0


def require_terminal(stdin: TextIO | None) -> None:
    """Unset variables that would disturb a screen; raise ArchoError unless one can be shown.

    Call it before Textual is imported, which reads these environment variables once.
    """
    for name in _FOREIGN:
        os.environ.pop(name, None)
    term = os.environ.get("TERM", "")
    if term in ("", "dumb", "unknown"):
        term_text = f"TERM is {term}" if term else "TERM is not set"
        raise ArchoError(f"{term_text}: this terminal cannot show a screen, use --plain")
    streams = {"stdin": stdin, "stdout": sys.stdout}
    if sys.platform != "win32":  # Textual's driver for POSIX draws on standard error.
        streams["stderr"] = sys.__stderr__
    for name, stream in streams.items():
        if stream is None or not stream.isatty():  # None if it is closed.
            raise ArchoError(f"{name} is not a terminal: run archo-tui in one, or use --plain")
        if _device(stream) != _device(stdin or stream):
            raise ArchoError(f"{name} is another terminal than stdin: run archo-tui in one of them")


def _device(stream: TextIO) -> int:
    """Return a terminal's device number, as a container may not know its name; 0 on Windows."""
    if sys.platform == "win32":
        return 0
    return os.fstat(stream.fileno()).st_rdev
