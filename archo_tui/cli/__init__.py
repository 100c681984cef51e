"""The command line of `archo-tui`, which imports rclpy and Textual only when it must."""

from __future__ import annotations

import errno
import gc
import os
import signal
import sys
from argparse import Namespace
from collections.abc import Callable, Sequence
from io import TextIOWrapper

from archo_tui.base.collector import ShortPauses
from archo_tui.base.errors import ArchoError
from archo_tui.base.system import END_SIGNALS, command_line
from archo_tui.cli import completion, graph, subcommands
from archo_tui.cli.console import run_console
from archo_tui.cli.launch import launch
from archo_tui.cli.options import (
    SUBCOMMANDS,
    OneLineErrorParser,
    add_subcommand_arguments,
    console_parser,
    split_line,
    split_ros_args,
)
from archo_tui.cli.verb import helps, send_stop, send_verb, wrong_option
from archo_tui.client import shell  # Loads quickly, since a prompt may call it.
from archo_tui.client.protocol import FAILED
from archo_tui.client.shell import complain, fail
from archo_tui.robot.stop.words import is_stop_text

_AGAIN = 100  # station.shutdown.RESTART, which is not imported for --help.
_RUN: dict[str, Callable[[Namespace], int]] = {
    "chapter": subcommands.write_chapter,
    "check": subcommands.check,
    "launch": launch,
    "keys": subcommands.print_keys,
    "completions": completion.print_completions,
    "consoles": lambda options: shell.print_consoles(as_json=options.json),
    "mcp": subcommands.serve_assistant,
    "recordings": subcommands.recordings,
    "replay": subcommands.replay,
    "journal": subcommands.print_journal_path,
    "robot": graph.describe_robot,
    "look": graph.look,
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program, print a user's mistake in one line, and return the exit code.

    A console that asks for a restart replaces this process.
    """
    # Before all else: a `stop` that is being typed must not stop.
    if "_ARGCOMPLETE" in os.environ and "COMP_LINE" in os.environ:
        completion.complete()
    if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Until heed_signals there is nothing to undo.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # None if it is closed.
            stream.reconfigure(errors="backslashreplace")
    given = sys.argv[1:] if argv is None else argv
    words, ros_args = split_ros_args(given)
    try:
        with ShortPauses():
            code = run_words(words, ros_args)
        if code == _AGAIN:
            for number in END_SIGNALS:  # An ignored one would be ignored after `exec`, too.
                signal.signal(number, signal.SIG_DFL)
            os.execv(sys.executable, command_line(given))
        if sys.stdout is not None:
            sys.stdout.flush()
        elif not code:  # Python drops what is printed then.
            complain("what was to be printed is lost: standard output is closed")
            code = FAILED
    except ArchoError as error:
        return fail("misuse", str(error), _without_program_arguments(words)[0])
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EPIPE, errno.EIO) or sys.stdout is None:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # It is flushed once more.
        # A reader that ends early, such as `head`, needs no message.
        if error.errno != errno.EPIPE:
            complain(f"cannot write to standard output: {error.strerror}")
        return FAILED
    finally:
        gc.enable()
        if signal.getsignal(signal.SIGINT) == signal.SIG_DFL:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    return code


def run_words(words: list[str], ros_args: list[str]) -> int:
    """Run the subcommand or the verb that the words name, else the console.

    If an option of the console is wrong but one of the words is a STOP, the STOP is sent; the words
    behind a subcommand are not looked through for one.
    """
    if words[:1] == ["help"]:  # No further word is passed on: a `stop` would stop.
        words = [*words[1:2], "--help"]
    words, arguments = _without_program_arguments(words)
    is_verb = words and words[0][:1] != "-" and words[0] not in SUBCOMMANDS
    if is_verb or is_stop_text(" ".join(words)):
        _check_unused(ros_args, words)
        return shell.run(words, SUBCOMMANDS, helps=helps)
    parser = console_parser()
    of_console, command = split_line(words, parser)
    name = command[0] if command else ""
    try:
        options = parser.parse_args(of_console)
        if name[:1] == "-":
            raise ArchoError(f"{name} is for a verb: archo-tui VERB --help says which")
        if name and name not in SUBCOMMANDS and (wrong := wrong_option(name, options, parser)):
            raise ArchoError(wrong)
    except ArchoError as error:
        at = next((number for number, word in enumerate(words) if is_stop_text(word)), None)
        if at is None:
            raise
        stop = command if is_stop_text(name) else words[at:]
        return send_stop(stop, words[:at], str(error), parser)
    if not name:
        options.arguments = arguments
        return run_console(options, ros_args)
    _check_unused(ros_args, command)
    if name not in SUBCOMMANDS:
        return send_verb(command, options)
    what, _ = SUBCOMMANDS[name]
    subparser = OneLineErrorParser(f"archo-tui {name}", f"{what[0].upper()}{what[1:]}.")
    add_subcommand_arguments(subparser, name)
    # Some of the console's options are the subcommand's too.
    return _RUN[name](subparser.parse_intermixed_args([*of_console, *command[1:]]))


def _without_program_arguments(words: list[str]) -> tuple[list[str], list[str]]:
    """Split `--node FILE -- ARG ...` at its `--`; without a `--node` before it nothing is split."""
    at = words.index("--") if "--" in words else len(words)
    if any(word.partition("=")[0] == "--node" for word in words[:at]):
        return words[:at], words[at + 1 :]
    return words, []


def _check_unused(ros_args: list[str], verb: list[str]) -> None:
    """Refuse ROS arguments before a verb, which they would not change; a STOP goes on."""
    if ros_args and not is_stop_text(" ".join(verb)):
        raise ArchoError(f"--ros-args is for the console, not for {verb[0]}")
