"""The completion of a shell's words, by argcomplete, as `ros2` has it.

Its script runs the program with the line in environment variables. That takes half a second at
most, prints nothing without an answer, and changes nothing on the robot. So it imports verbs only
for an option that is typed where no console runs.
"""

from __future__ import annotations

import argparse
import contextlib
import re
from collections.abc import Iterable, Sequence
from typing import NoReturn

from archo_tui.base.errors import ArchoError
from archo_tui.cli.options import (
    ENGINES,
    SUBCOMMANDS,
    OneLineErrorParser,
    add_subcommand_arguments,
    console_parser,
    split_line,
)
from archo_tui.cli.verb import verbs_of_file
from archo_tui.client import find
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import FAILED
from archo_tui.client.shell import CommandLine
from archo_tui.robot_file.reserved import VERBS

_TIMEOUT = 0.25  # Seconds, twice: for the hello of a console, and for its answer.
# A robot chooses the names on its graph. A word that a shell could read as anything but itself is
# not offered.
_PLAIN_WORD = re.compile(r"[\w./:=+-]+", re.ASCII)


def print_completions(options: argparse.Namespace) -> int:
    """Print the completion script of a shell, and return 0."""
    from argcomplete.shell_integration import shellcode

    # Without bash's defaults: where nothing fits, files do not fit, either.
    script = shellcode(["archo-tui"], shell=options.shell, complete_arguments=["-o", "nospace"])
    print(script.strip())
    return 0


def complete() -> NoReturn:
    """Answer the script that has run this process, and end it."""
    from argcomplete.completers import FilesCompleter
    from argcomplete.finders import CompletionFinder

    class Finder(CompletionFinder):
        """A finder of the words that fit, which a parser alone does not know."""

        def _get_completions(
            self, comp_words: list[str], cword_prefix: str, cword_prequote: str, last: int | None
        ) -> list[str]:
            found = fitting([*comp_words[1:], cword_prefix])
            if found is None:
                found = list(FilesCompleter()(cword_prefix))
            self._display_completions = dict.fromkeys(found, "")
            quoted: list[str] = self.quote_completions(found, cword_prequote, last)
            return quoted

    Finder()(OneLineErrorParser("archo-tui", ""))
    raise SystemExit(FAILED)  # Not reached: the call ends the process.


def fitting(words: Sequence[str]) -> list[str] | None:
    """Return the words that may stand in the place of the last one; None if files may."""
    with contextlib.suppress(ArchoError, OSError, ValueError):
        found = _candidates(words)
        if found is None:
            return None
        fits = (word for word in found if word.startswith(words[-1]))
        return [word for word in fits if _PLAIN_WORD.fullmatch(word)]
    return []


def _candidates(words: Sequence[str]) -> Iterable[str] | None:
    """Return the words that may stand in the place of the last one; None for files."""
    *before, unfinished = words
    parser = console_parser()
    of_console, command = split_line(before, parser)
    name = command[0] if command else ""
    if name in SUBCOMMANDS:
        parser = OneLineErrorParser(name, "")
        add_subcommand_arguments(parser, name)
    option = parser._option_string_actions.get(before[-1]) if before else None
    if option is not None and option.nargs is None:  # The word is its value.
        choices = ENGINES if option.dest == "engine" else option.choices
        return choices or (None if option.metavar in ("FILE", "DIR") else ())
    if name and name not in SUBCOMMANDS:
        return _of_verb(CommandLine(command), parser.parse_args(of_console), unfinished)
    if unfinished[:1] == "-":
        return parser._option_string_actions
    if not name:
        with contextlib.suppress(Unreached):
            return [*SUBCOMMANDS, *_of_console("", parser.parse_args(of_console), [unfinished])]
        return [*SUBCOMMANDS, *VERBS]
    if name in ("replay", "recordings"):
        from archo_tui.recordings.store import own_recordings

        names = [recording.name for recording in own_recordings()]
        return names if any(each.startswith(unfinished) for each in names) else None
    values = [action for action in parser._actions if not action.option_strings]
    return values[0].choices if values else ()


def _of_verb(
    line: CommandLine, options: argparse.Namespace, unfinished: str
) -> Iterable[str] | None:
    typed = [word for word in line.rest if word != "--yes"]
    if typed[:1] in (["load"], ["save"]) and unfinished[:1] != "-":
        return None
    try:
        return _of_console(line.values.get("--to", ""), options, [*typed, unfinished])
    except Unreached:
        if unfinished[:1] != "-":
            return ()
        verb = verbs_of_file().get(typed[0])
        return () if verb is None else verb.option_names


def _of_console(to: str, options: argparse.Namespace, words: Sequence[str]) -> list[str]:
    selection = {"to": to or options.namespace, "engine": options.engine}
    with find.choose(selection, _TIMEOUT) as console:
        found = console.answer(_TIMEOUT, complete=[*words]).get("data")
    return [word for word in found if isinstance(word, str)] if isinstance(found, list) else []
