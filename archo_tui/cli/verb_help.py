"""The verbs of a robot file, for help and completion where no console runs."""

from __future__ import annotations

from archo_tui.client.options import help_with_options

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

    from archo_tui.verbs.verb import Verb


def verbs_of_file(path: Path | None = None) -> dict[str, Verb]:
    """Return a robot's verbs by id; fields of goals count as int32, as no interface is read."""
    from archo_tui.robot.messages.types import TypedField
    from archo_tui.robot_file.load import default_path, load
    from archo_tui.verbs import verbs

    robot = load(path or default_path())
    return verbs(
        robot,
        {goal.id: [TypedField(path, "int32", 0) for path in goal.form] for goal in robot.goals},
    )


def helps(path: Path | None = None) -> dict[str, str]:
    """Return the help of each verb of a robot file, by what is typed. Raises ArchoError."""
    known = verbs_of_file(path).values()
    return {verb.id: help_with_options(verb.id, verb.help_line, verb.options) for verb in known}
