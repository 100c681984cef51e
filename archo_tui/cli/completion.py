"""The completion of a shell's words: the script, and `archo-tui __complete WORD ...` that it calls.

That takes half a second at most, prints nothing without an answer, and changes nothing on the
robot. So it imports neither shtab nor verbs.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import sys
from collections.abc import Iterable, Sequence

from archo_tui.cli.options import (
    COMPLETE,
    ENGINES,
    SUBCOMMANDS,
    OneLineErrorParser,
    add_subcommand_arguments,
    console_parser,
)
from archo_tui.cli.verb import verbs_of_file
from archo_tui.client import find
from archo_tui.errors import ArchoError
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from archo_tui.verbs.verb import Argument

# The names of the functions have `file` in them where shtab shall complete file names.
_BASH = f"""\
_archo_tui_ask() {{
  local word
  while IFS= read -r word; do
    [[ $word == "$1"* ]] && printf '%s\\n' "$word"
  done < <(archo-tui {COMPLETE} "${{COMP_WORDS[@]:1:COMP_CWORD}}" 2>/dev/null)
}}
_archo_tui_ask_or_file() {{
  _archo_tui_ask "$1"
  compgen -f -- "$1"
}}"""
_ZSH = f"""\
_archo_tui_ask() {{
  local -a found
  found=(${{(f)"$(archo-tui {COMPLETE} "${{(@)words[1,CURRENT]}}" 2>/dev/null)"}})
  compadd -a found
}}
_archo_tui_ask_or_file() {{
  _archo_tui_ask
  _files
}}"""
_FISH = f"""\
function _archo_tui_ask
  set -l before (commandline -opc)
  archo-tui {COMPLETE} $before[2..] (commandline -ct) 2>/dev/null
end
function _archo_tui_ask_or_file
  _archo_tui_ask
  __fish_complete_path (commandline -ct)
end"""
_PREAMBLE = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}
_ASK = {"bash": "_archo_tui_ask", "zsh": "_archo_tui_ask", "fish": "(_archo_tui_ask)"}
_ASK_OR_FILE = {
    "bash": "_archo_tui_ask_or_file",
    "zsh": "_archo_tui_ask_or_file",
    "fish": "(_archo_tui_ask_or_file)",
}


def print_completions(options: argparse.Namespace) -> int:
    """Print the completion script of a shell, and return 0."""
    print(completion_script(options.shell))
    return 0


def completion_script(shell: str) -> str:
    """Return the completion script of bash, zsh or fish, which asks `archo-tui __complete`."""
    import shtab

    parser = console_parser()
    commands = parser.add_subparsers(metavar="COMMAND", parser_class=OneLineErrorParser)
    _add_completers(parser)
    for name, (what, _) in SUBCOMMANDS.items():
        subparser = commands.add_parser(name, help=what, description=what)
        add_subcommand_arguments(subparser, name)
        _add_completers(subparser)
    for name, verb in verbs_of_file().items():
        subparser = commands.add_parser(name, help=verb.help, description=verb.help)
        _add_options(subparser, verb.options)
        for argument in verb.arguments:
            _add_argument(subparser, argument)
    script = str(shtab.complete(parser, shell=shell, preamble=_PREAMBLE[shell]))
    return _with_repeated_words(script) if shell == "zsh" else script


def _with_repeated_words(script: str) -> str:
    """Return a zsh script that completes each word of an argument that takes several.

    With shtab's `(*)` zsh completes the first word only.
    """
    return script.replace('"(*)::', '"*:').replace('"(*):', '"*:')


def _add_completers(parser: argparse.ArgumentParser) -> None:
    """Tell shtab how the values of a parser's options are completed."""
    import shtab

    for action in parser._actions:
        if action.metavar in ("FILE", "PATH"):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
        elif action.metavar == "DIR":
            action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
        elif action.metavar == "RECORDING":
            action.complete = _ASK_OR_FILE  # type: ignore[attr-defined]
        elif action.metavar == "NAME":  # Of a recording to delete.
            action.complete = _ASK  # type: ignore[attr-defined]
        elif action.dest == "engine":
            action.choices = ENGINES


def _add_options(parser: argparse.ArgumentParser, options: Iterable[tuple[str, str]]) -> None:
    for option, does in options:
        name, _, value = option.partition(" ")
        if value:
            parser.add_argument(name, metavar=value, help=does)
        else:
            parser.add_argument(name, action="store_true", help=does)


def _add_argument(parser: argparse.ArgumentParser, argument: Argument) -> None:
    import shtab

    if argument.takes:  # Among the options, with what it does.
        return
    if argument.is_flag:
        parser.add_argument(argument.name, action="store_true")
        return
    nargs = "*" if argument.many or argument.rest else None
    action = parser.add_argument(argument.name.replace("=", "_"), nargs=nargs)
    action.complete = shtab.FILE if argument.name == "file" else _ASK  # type: ignore[attr-defined]


_TIMEOUT = 0.25  # Seconds, twice: for the hello of a console, and for its answer.
# A robot chooses the names on its graph. A word that a shell could read as anything but itself is
# not offered.
_PLAIN_WORD = re.compile(r"[\w./:=+-]+", re.ASCII)


def print_candidates(words: Sequence[str]) -> int:
    """Print the words that may follow, except those that a shell interprets, and return 0."""
    with contextlib.suppress(argparse.ArgumentError, ArchoError, OSError, ValueError):
        for word in _candidates(words):
            if _PLAIN_WORD.fullmatch(word):
                sys.stdout.write(f"{word}\n")
    return 0


def _candidates(words: Sequence[str]) -> Iterable[str]:
    *before, unfinished = words
    if before[:1] in (["replay"], ["recordings"]):
        from archo_tui.recordings.store import own_recordings

        return [recording.name for recording in own_recordings()]
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    for option in (*VERB_VALUES, "--engine", "--namespace"):
        parser.add_argument(option, default="")
    for flag in (*VERB_FLAGS, "--yes"):
        parser.add_argument(flag, action="store_true")
    options, line = parser.parse_known_args(before)
    selection = {"to": options.to or options.namespace, "engine": options.engine}
    with find.choose(selection, _TIMEOUT) as console:
        found = console.answer(_TIMEOUT, complete=[*line, unfinished]).get("data")
    return [word for word in found if isinstance(word, str)] if isinstance(found, list) else ()
