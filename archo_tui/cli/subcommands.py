"""The subcommands that are no verb, no launch file and no robot file."""

from __future__ import annotations

import os
import shlex
import signal
import sys
import threading
from argparse import Namespace
from pathlib import Path

from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import safe
from archo_tui.cli.console import require_terminal
from archo_tui.cli.options import ENGINES
from archo_tui.client.protocol import FAILED
from archo_tui.client.shell import complain

_PACKAGE = Path(__file__).parents[1]
_INTERFACES = ("CMakeLists.txt", "package.xml", "msg", "srv", "action")
_NEXT = """\
See them:     archo-tui --node {workspace} --only
Launch them:  archo-tui launch {workspace} use_sim:=true
Check them:   archo-tui check {workspace}
On ROS 2:     cd {workspace} && colcon build"""


def check(options: Namespace) -> int:
    """Run the checks of the textbook's chapter on files; 0 if some passed and none failed."""
    from archo_tui.cli.check import run

    signal.signal(signal.SIGINT, signal.default_int_handler)  # So that temporary files are removed.
    out = sys.stdout
    try:
        return run(
            options.files,
            options.engine or ENGINES[0],
            options.interfaces,
            lambda line: print(line, file=out, flush=True),
        )
    except KeyboardInterrupt:
        complain("interrupted: not all was checked")
        return FAILED


def print_keys(options: Namespace) -> int:
    """Print the key of each command, in the form of keymap.yaml, and return 0."""
    from archo_tui.base.paths import config_file
    from archo_tui.robot_file import load
    from archo_tui.screen.commands import keymap, registry

    path = config_file("keymap.yaml")
    robot = load.load(options.robot or load.default_path())
    commands = registry(robot)
    keys, others = keymap.load_keymap(path, commands)
    print(safe(f"# {path}"))
    for command in commands:
        key, place = keys[command.id], command.where_text
        line = f"{command.id}: {key}" if key else f"# {command.id}:"
        if not key:
            place = "in the palette only"
            taker = keymap.key_owner(command, command.key, keys, commands)
            place += f", {command.key} is the key of {taker}" if taker else ""
        print(safe(f"{line:<{len(command.id) + 18}} # {place}: {command.help}"))
    if others:
        complain(others)
    return 0


def serve_assistant(options: Namespace) -> int:
    """Serve an assistant on standard input and output until the input ends, and return 0."""
    try:
        from archo_tui.client.mcp.server import serve
    except ImportError:  # The SDK is missing or too old.
        text = "mcp needs another package: pip install '.[mcp]' in a clone of archo-tui"
        raise ArchoError(text) from None
    if sys.stdin is None or sys.stdout is None:
        raise ArchoError("mcp needs a standard input and output, and one is closed")
    if sys.stdin.isatty():
        complain("mcp is started by an assistant's program, which speaks on standard input")
    serve(goals=options.allow == "goals", to=options.to)
    return 0


def print_journal_path(_options: Namespace) -> int:
    """Print the path of the journal, and return 0."""
    from archo_tui.base.paths import journal_file

    print(safe(str(journal_file())))
    return 0


def replay(options: Namespace) -> int:
    """Show a recording on the screen until it is left, or with `--text` print what happened."""
    from archo_tui.ros import engine
    from archo_tui.user_code import interfaces as own_interfaces

    if not options.text:
        try:
            require_terminal(sys.stdin)
        except ArchoError as error:  # Without a terminal a replay offers --text.
            raise ArchoError(str(error).replace("--plain", "--text")) from None
    own, mistakes = own_interfaces.find(options.interfaces, "embedded")
    for line in mistakes:
        complain(f"not read: {line}")
    engine.activate("embedded", own=own)
    from archo_tui.base.clock import Clock
    from archo_tui.recordings.replay.player import load_robot_file, make_player, open_bag

    bag = open_bag(options.recording)
    robot = load_robot_file(bag, str(options.robot or ""))
    if options.text:
        from archo_tui.recordings.replay.player import report_lines

        for line in report_lines(bag, robot):
            print(safe(line))
        return 0
    from archo_tui.base.handover import CONSOLE_SOCKET, GO, READY, STOP_KEY
    from archo_tui.base.imports import OF_THE_SCREEN, import_the_rest
    from archo_tui.base.paths import config_file
    from archo_tui.recordings.replay.station import RecordedStation
    from archo_tui.screen.app import ArchoApp
    from archo_tui.screen.commands import keymap, registry
    from archo_tui.screen.terminal import themes
    from archo_tui.screen.terminal.stderr import guarded_streams, log_file
    from archo_tui.station.shutdown import heed_signals

    keys, _ = keymap.load_keymap(config_file("keymap.yaml"), registry(robot))
    keys["stop"] = os.environ.get(STOP_KEY, keys["stop"])
    heed_signals()
    import_the_rest(OF_THE_SCREEN)
    clock = Clock()
    player = make_player(bag, robot, clock)
    station = RecordedStation(player, clock)
    app = ArchoApp(station, keys, themes.remembered_theme(), player=player)
    if console := os.environ.get(CONSOLE_SOCKET, ""):  # It lends its terminal when that is needed.
        os.write(int(console), READY)
        if os.read(int(console), 1) != GO:
            return 0
        app.has_lent_terminal = True
        threading.Thread(target=_end_with_console, args=(int(console),), daemon=True).start()
    with guarded_streams(log_file()):
        app.run()
    if app.failure:
        complain(f"the screen crashed: {app.failure.strip().splitlines()[-1]}")
    return app.return_code or 0


def _end_with_console(descriptor: int) -> None:
    """Wait for the end of the console that plays this, which may be killed; then end this, too."""
    os.read(descriptor, 1)
    os.kill(os.getpid(), signal.SIGTERM)


def recordings(options: Namespace) -> int:
    """Print a line for each recording of the black box, or for each one that is deleted."""
    from archo_tui.recordings import store

    if options.delete:
        for line in store.delete_named(options.delete):
            print(safe(line))
        return 0
    for line in store.listing(as_json=options.json):
        print(safe(line))
    return 0


def write_chapter(options: Namespace) -> int:
    """Write a workspace with the chapter's nodes, launch file, parameters and interfaces.

    Raises ArchoError, and writes nothing, if one of the files is there.
    """
    import shutil

    if not options.folder.strip():
        raise ArchoError("type the name of a folder")
    workspace = Path(options.folder)
    files = {workspace / name: source for name, source in _sources().items()}
    if there := next((path for path in files if path.exists() or path.is_symlink()), None):
        raise ArchoError(f"{there} is there already: nothing was written; name another folder")
    try:
        for path, source in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, path)
    except OSError as error:
        raise ArchoError(f"{error.filename or workspace}: not written: {error.strerror}") from None
    for line in [
        *map(str, files),
        *_NEXT.format(workspace=shlex.quote(str(workspace))).split("\n"),
    ]:
        print(safe(line))
    return 0


def _sources() -> dict[Path, Path]:
    """Return the file to copy for each path below the workspace."""
    in_clone = (_PACKAGE.parent / "interfaces" / "package.xml").is_file()
    root = _PACKAGE.parent if in_clone else _PACKAGE
    interfaces = root / ("interfaces" if in_clone else "ros/embedded/share/archo_interfaces")
    sources = {Path(): root / "config" / "chapter"}
    sources |= {Path("src/archo_interfaces", name): interfaces / name for name in _INTERFACES}
    return {
        place / path.relative_to(source): path
        for place, source in sources.items()
        for path in sorted([source, *source.rglob("*")])
        if path.is_file() and "__pycache__" not in path.parts
    }
