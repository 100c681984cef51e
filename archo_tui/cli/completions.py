"""`archo-tui completions SHELL`: the script by which a shell completes our words."""

from __future__ import annotations

from argparse import Namespace

from archo_tui.cli.options import SUBCOMMANDS, console_parser
from archo_tui.cli.parser import OneLineErrorParser


def print_completions(options: Namespace) -> int:
    """Print a shell's completion script, which knows the verbs of ARCHO's robot file."""
    import shtab

    from archo_tui.remote.verb_help import options_of, verbs_of_file

    parser = console_parser(takes_command=False)
    commands = parser.add_subparsers(metavar="COMMAND", parser_class=OneLineErrorParser)
    for name, (what, add_options) in SUBCOMMANDS.items():
        add_options(commands.add_parser(name, help=what, description=what))
    verbs = {
        verb.id: (verb.help, verb.options)
        for verb in verbs_of_file().values()
        if verb.id not in SUBCOMMANDS
    }
    verbs["wait"] = "Wait until the robot is in that state", ()
    for name, (what, takes) in verbs.items():
        verb_parser = commands.add_parser(name, help=what, description=what)
        for option, _ in options_of(name, takes):
            verb_parser.add_argument(*option.split()[:1], action="store_true")
    for action in parser._actions:
        if action.metavar in ("FILE", "DIR", "PATH"):
            action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(parser, shell=options.shell))
    return 0
