"""The verbs: everything an operator can do to the robot, shared by all frontends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from archo_tui.robot.messages.types import TypedField
from archo_tui.robot_file.model import RobotFile
from archo_tui.verbs.alarms import Acknowledge, Alarms, Shelve
from archo_tui.verbs.goals import Cancel, ContinueQueue, Go, SendGoal, SkipGoal
from archo_tui.verbs.nodes import DuplicateNode, Lifecycle, LogLevel, Nodes, StartNode, StopNode
from archo_tui.verbs.parameters import Get, Load, Params, Save, Set, Undo
from archo_tui.verbs.places import Drive, SavePlace, SaveQueue, ShowPlaces
from archo_tui.verbs.publish import Publish
from archo_tui.verbs.services import Call, Give
from archo_tui.verbs.show import Events, ForgetPart, Keep, ShowDiagnostics, ShowHistory, Status
from archo_tui.verbs.stop import GiveUpStop, ReleaseStop, StopNow
from archo_tui.verbs.topics import Echo, Hz, ShowInterface, ShowTransforms, Topics
from archo_tui.verbs.verb import Verb


def verbs(robot: RobotFile, forms: Mapping[str, Sequence[TypedField]]) -> dict[str, Verb]:
    """Return all verbs of a robot by the word that is typed, those for goals first.

    The first goal of the robot file has the verb `go`, each further goal its id. A command that is
    a toggle has two. `forms` lacks goals whose type is not installed.
    """
    return {verb.id: verb for verb in _all(robot, forms)}


def _all(robot: RobotFile, forms: Mapping[str, Sequence[TypedField]]) -> Iterator[Verb]:
    goals = [
        Go(kind, forms.get(kind.id), "" if number else "go")
        for number, kind in enumerate(robot.goals)
    ]
    ask = goals[0].how if goals else ""
    yield from goals
    if goals:
        yield from (ShowPlaces(), SavePlace(goals), SaveQueue(), Drive(goals))
    yield from (Cancel(), ContinueQueue(), SkipGoal())
    yield from (StopNow(robot.stop), ReleaseStop(robot.stop), GiveUpStop())
    for command in robot.commands:
        yield Give(command)
        if command.toggle:
            yield Give(command, on=False)
    yield from (Status(ask, robot), ShowHistory(), Events(), Keep())
    yield from (Alarms(), Acknowledge(), Shelve(), ShowDiagnostics(), ForgetPart())
    yield from (Params(), Get(), Set(), Undo(), Save(), Load())
    yield from (Nodes(), Topics(), Echo(), Hz(), ShowInterface(), ShowTransforms())
    yield from (StartNode(), StopNode(), DuplicateNode(), LogLevel(), Lifecycle())
    yield from (SendGoal(), Call(), Publish())
