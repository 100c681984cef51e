"""The verbs: everything an operator can do to the robot, shared by all frontends."""

from __future__ import annotations

from archo_tui.robot_file.model import RobotFile
from archo_tui.verbs import (
    alarms,
    goals,
    nodes,
    parameters,
    places,
    services,
    show,
    stop,
    topics,
    waits,
)
from archo_tui.verbs.verb import Forms, Verb

# In the order in which help lists them.
_FILES = goals, places, stop, services, show, alarms, parameters, nodes, topics, waits
# Every class of a verb in them; the bases of several have no word.
_KINDS = [
    kind
    for file in _FILES
    for name, kind in vars(file).items()
    if isinstance(kind, type) and issubclass(kind, Verb)
    if kind.__module__ == file.__name__ and not name.startswith("_") and kind is not goals.GoalVerb
]


def verbs(robot: RobotFile, forms: Forms) -> dict[str, Verb]:
    """Return all verbs of a robot by the word that is typed, those for goals first.

    The first goal of the robot file has the verb `go`, each further goal its id. A command that is
    a toggle has two.
    """
    return {verb.id: verb for kind in _KINDS for verb in kind.of_robot(robot, forms)}
