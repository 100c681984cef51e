"""`archo-tui launch`: a console for the programs of the user's own launch file."""

from __future__ import annotations

import tempfile
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import safe
from archo_tui.cli.console import run_console
from archo_tui.cli.options import console_parser
from archo_tui.client.protocol import FAILED
from archo_tui.client.shell import complain

TYPE_CHECKING = False
if TYPE_CHECKING:
    from archo_tui.user_code.ros_launch.plan import LaunchArgument

_SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml")  # As ROS 2's launch files end.


def launch(options: Namespace) -> int:
    """Run the console with a launch file, or print the arguments that the file declares."""
    from archo_tui.session.options import Launch
    from archo_tui.user_code.launch_file import NothingRunsError
    from archo_tui.user_code.ros_launch.evaluate import evaluate, parse_arguments
    from archo_tui.user_code.ros_launch.workspace import Workspace

    file = _launch_file(options.file)
    if options.show_args:
        with tempfile.TemporaryDirectory(prefix="archo-launch-") as prefix:
            plan = evaluate(str(file), Workspace.around(file), Path(prefix), None)
        for line in _argument_lines(plan.arguments):
            print(safe(line))
        return 0
    chosen = Launch(file, parse_arguments(options.arguments))
    console = vars(console_parser().parse_args(["--only"])) | vars(options) | {"arguments": ()}
    try:
        return run_console(Namespace(**console), [], chosen)
    except NothingRunsError as error:
        for text in map(str, (*error.notes, error)):
            complain(text)
        return FAILED


def _launch_file(given: Path) -> Path:
    """Return a given file as it is, or for a workspace the only launch file of its packages."""
    if not given.is_dir():
        return given
    from archo_tui.user_code.ros_launch.workspace import Workspace

    folders = [package.folder for package in Workspace.below(given).packages.values()]
    found = sorted(
        path
        for folder in folders
        for path in folder.glob("launch/*")
        if path.name.endswith(_SUFFIXES)
    )
    if not found:
        raise ArchoError(f"{given}: no package of it has launch/*{_SUFFIXES[0]}, .xml or .yaml")
    if len(found) > 1:
        raise ArchoError(f"{given} has several launch files, name one: {' '.join(map(str, found))}")
    return found[0]


def _argument_lines(arguments: Sequence[LaunchArgument]) -> list[str]:
    if not arguments:
        return ["no arguments"]
    lines = []
    for argument in arguments:
        default = "no default" if argument.default is None else f"default: {argument.default}"
        choices = f", one of {' '.join(argument.choices)}" if argument.choices else ""
        only = ", in some cases only" if argument.is_conditional else ""
        about = f"  {argument.description}" if argument.description else ""
        lines.append(f"{argument.name}:={about}  ({default}{choices}{only})")
    return lines
