"""The subcommands that take a few lines: check, keys, completions, consoles, mcp, ...."""

from __future__ import annotations

import signal
import sys
from argparse import Namespace

from archo_tui.cli.output import FAILED, complain
from archo_tui.errors import ArchoError
from archo_tui.safe_text import safe


def check(options: Namespace) -> int:
    """Run the checks of the textbook's chapter on files; 0 if some passed and none failed."""
    from pathlib import Path

    from archo_tui.cli.check import run

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
        complain("interrupted: not all was checked")
        return FAILED


def print_keys(options: Namespace) -> int:
    """Print the key of each command, in the form of keymap.yaml, and return 0."""
    from pathlib import Path

    from archo_tui.commands import keymap, registry
    from archo_tui.paths import config_file
    from archo_tui.robot_file import load

    path = config_file("keymap.yaml")
    robot = load.load(Path(options.robot) if options.robot else load.default_path())
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


def list_consoles(options: Namespace) -> int:
    """Print the consoles that run here; return 0 if there are any and all answer properly."""
    from archo_tui.client.shell import print_consoles

    return print_consoles(["--json"] if options.json else [])


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
    from archo_tui.paths import journal_file

    print(safe(str(journal_file())))
    return 0
