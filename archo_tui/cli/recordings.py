"""The subcommands for recordings: the list of them, and `replay` on the screen or as text."""

from __future__ import annotations

import os
import signal
import sys
import threading
from argparse import Namespace

from archo_tui.cli.console import require_terminal
from archo_tui.cli.output import complain
from archo_tui.errors import ArchoError
from archo_tui.safe_text import safe


def replay(options: Namespace) -> int:
    """Show a recording on the screen until it is left, or with `--text` print what happened."""
    from pathlib import Path

    from archo_tui import engine
    from archo_tui.user_code import interfaces as own_interfaces

    if not options.text:
        try:
            require_terminal(sys.stdin)
        except ArchoError as error:  # Without a terminal a replay offers --text.
            raise ArchoError(str(error).replace("--plain", "--text")) from None
    given = [Path(folder) for folder in options.interfaces]
    own, mistakes = own_interfaces.find(given, "embedded")
    for line in mistakes:
        complain(f"not read: {line}")
    engine.activate("embedded", own=own)
    from archo_tui.clock import Clock
    from archo_tui.recordings.replay.player import load_robot_file, make_player, open_bag

    bag = open_bag(options.recording)
    robot = load_robot_file(bag, options.robot)
    if options.text:
        from archo_tui.recordings.replay.player import report_lines

        for line in report_lines(bag, robot):
            print(safe(line))
        return 0
    from archo_tui.app import ArchoApp
    from archo_tui.commands import keymap, registry
    from archo_tui.handover import CONSOLE_SOCKET, GO, READY
    from archo_tui.imports import OF_THE_SCREEN, import_the_rest
    from archo_tui.paths import config_file
    from archo_tui.recordings.replay.station import RecordedStation
    from archo_tui.shutdown import heed_signals
    from archo_tui.terminal import themes
    from archo_tui.terminal.stderr import guarded_streams, log_file

    keys, _ = keymap.load_keymap(config_file("keymap.yaml"), registry(robot))
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
