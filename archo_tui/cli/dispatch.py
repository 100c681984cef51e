"""The choice of what the words of a command line run: the console, a subcommand or a verb."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable

from archo_tui.cli import subcommands
from archo_tui.cli.chapter import write_chapter
from archo_tui.cli.console import run_console
from archo_tui.cli.describe import describe_robot
from archo_tui.cli.launch import launch
from archo_tui.cli.look import look
from archo_tui.cli.options import COMPLETE, SUBCOMMANDS, console_parser
from archo_tui.cli.output import report_lost_output
from archo_tui.cli.parser import OneLineErrorParser
from archo_tui.cli.replay import replay
from archo_tui.cli.verb import send_stop, send_verb
from archo_tui.cli.verb_help import helps
from archo_tui.errors import ArchoError
from archo_tui.robot.stop.words import is_stop_text

_RUN: dict[str, Callable[[Namespace], int]] = {
    "chapter": write_chapter,
    "check": subcommands.check,
    "launch": launch,
    "keys": subcommands.print_keys,
    "completions": subcommands.print_completions,
    "consoles": subcommands.list_consoles,
    "mcp": subcommands.serve_assistant,
    "recordings": subcommands.recordings,
    "replay": replay,
    "journal": subcommands.print_journal_path,
    "robot": describe_robot,
    "look": look,
}


def run_words(words: list[str], ros_args: list[str]) -> int:
    """Run the subcommand or the verb that the words name, else the console.

    If an option of the console is wrong but one of the words is a STOP, the STOP is sent; the words
    behind a subcommand are not looked through for one.
    """
    if words[:1] == [COMPLETE]:  # Before all else: a `stop` that is being typed must not stop.
        from archo_tui.cli.complete import print_candidates

        return print_candidates(words[1:])
    if words[:1] == ["help"]:  # No further word is passed on: a `stop` would stop.
        words = [*words[1:2], "--help"]
    words, arguments = _without_program_arguments(words)
    is_verb = words and words[0][:1] != "-" and words[0] not in SUBCOMMANDS
    if is_verb or is_stop_text(" ".join(words)):
        from archo_tui.client import shell  # Runs quickly, since a prompt may call it.

        report_lost_output()
        _check_unused(ros_args, words)
        return shell.run(words, SUBCOMMANDS, helps=helps)
    parser = console_parser()
    try:
        options = parser.parse_args(words)
        if options.verb_options and not options.command:
            raise ArchoError(
                f"{options.verb_options[0]} is for a verb: archo-tui VERB --help says which"
            )
    except ArchoError as error:
        at = next((number for number, word in enumerate(words) if is_stop_text(word)), None)
        if at is None:
            raise
        report_lost_output()
        return send_stop(words[at:], words[:at], str(error), parser)
    if not options.command:
        options.program_arguments = arguments
        return run_console(options, ros_args)
    name, *rest = options.command
    if name != "mcp":  # mcp uses standard output for its protocol.
        report_lost_output()
    if name not in SUBCOMMANDS:
        _check_unused(ros_args, options.command)
        return send_verb(options, parser, words)
    what, add_options = SUBCOMMANDS[name]
    subparser = OneLineErrorParser(f"archo-tui {name}", f"{what[0].upper()}{what[1:]}.")
    add_options(subparser)
    # Some of the console's options are the subcommand's too.
    before = words[: -len(options.command)]
    _check_unused(ros_args, options.command)
    return _RUN[name](subparser.parse_intermixed_args([*before, *rest]))


def _without_program_arguments(words: list[str]) -> tuple[list[str], list[str]]:
    """Split `--node FILE -- ARG ...` at its `--`; without a `--node` before it nothing is split."""
    at = words.index("--") if "--" in words else len(words)
    if any(word.partition("=")[0] in ("--node", "--run") for word in words[:at]):
        return words[:at], words[at + 1 :]
    return words, []


def _check_unused(ros_args: list[str], verb: list[str]) -> None:
    """Refuse ROS arguments before a verb, which they would not change; a STOP goes on."""
    if ros_args and not is_stop_text(" ".join(verb)):
        raise ArchoError(f"--ros-args is for the console, not for {verb[0]}")
