"""The registry of commands: keys, footer, `?`, palette, buttons and docs/keys.md use it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from archo_tui.robot_file.model import RobotFile
from archo_tui.screen.commands import (
    alarms,
    console,
    events,
    generic,
    graph,
    help,
    nodes,
    palette,
    parameters,
    recordings,
    robot,
)
from archo_tui.screen.commands.base import IN_PANEL, Command, PanelKey, VerbCommand, everywhere
from archo_tui.screen.main import PANELS
from archo_tui.screen.widgets.parameters_panel import ParametersPanel
from archo_tui.verbs import verbs as vocabulary
from archo_tui.verbs.goals import Go
from archo_tui.verbs.parameters import CHANGE
from archo_tui.verbs.places import SavePlace, SaveQueue
from archo_tui.verbs.services import Give
from archo_tui.verbs.topics import Publish
from archo_tui.verbs.verb import Verb

_HELP = "Show all keys; works in dialogs and while typing, too"
_CANCEL_ALL = "Cancel every goal, whoever sent it (asks first)"


def _saves_pose(verb: Verb) -> bool:
    return isinstance(verb, SavePlace) and verb.pose_goal is not None


def registry(described: RobotFile, spoken: Mapping[str, Verb] | None = None) -> tuple[Command, ...]:
    """Return every command of the console for a robot, in the order of the footer.

    `spoken` has the robot's verbs by word; None makes verbs that serve for keys and help only.
    """
    verbs = vocabulary(described, {}) if spoken is None else spoken
    goals = [verb for verb in verbs.values() if isinstance(verb, Go)]
    return (
        robot.GoKey(goals[0] if goals else None),
        robot.CancelKey(verbs["cancel"]),
        VerbCommand(verbs["cancel"], lambda _: {"--all": True}, id="cancel_all", help=_CANCEL_ALL),
        VerbCommand(verbs["continue"], key="n"),
        VerbCommand(verbs["skip"], key="k"),
        robot.StopKey(verbs["stop"]),
        VerbCommand(verbs["give_up_stop"]),
        VerbCommand(verbs["release"], key="R", waits_for_answer=True),
        *(robot.GiveKey(on, off) for on, off in _robot_file_commands(verbs)),
        *(robot.FormGoalKey(goal) for goal in goals[1:]),
        generic.AnyGoal(verbs["send_goal"]),
        generic.AnyService(verbs["call"]),
        *(generic.AnyTopic(verb) for verb in verbs.values() if isinstance(verb, Publish)),
        generic.DescribeRobot(),
        *(robot.SaveUnderName(v, "places") for v in verbs.values() if _saves_pose(v)),
        *(robot.SaveUnderName(v, "go_list") for v in verbs.values() if isinstance(v, SaveQueue)),
        VerbCommand(verbs["ack"], key="a", help="Acknowledge the alarm in the banner"),
        alarms.ShowAlarms(),
        alarms.ListDiagnostics(),
        *(PanelKey(panel, described) for panel in PANELS),
        parameters.Edit(),
        parameters.EditWithInitial(),
        parameters.SwitchBoolean(),
        parameters.ToggleOnlyChanged(),
        parameters.ToggleHidden(),
        parameters.FilterParameters(),
        VerbCommand(
            verbs["undo"],
            lambda station: {CHANGE: station.edits.last},
            **{"where": IN_PANEL, "panel": ParametersPanel, "key": "u", "waits_for_answer": True},
        ),
        parameters.SaveKey(verbs["save"]),
        parameters.LoadKey(verbs["load"]),
        nodes.StartStop(),
        nodes.CopyNode(),
        nodes.Restart(),
        nodes.ShowNode(),
        events.NextLevel(),
        events.SearchEvents(),
        events.CopyCommand(),
        events.ToggleFullScreen(),
        events.ShowEvent(),
        events.SaveEvents(),
        events.ShowHistory(),
        events.ChangeSpan(-1),
        events.ChangeSpan(1),
        graph.ShowResource(),
        graph.ShowFrames(),
        help.ShowHelp(),
        everywhere(help.ShowHelp(), "help_everywhere", "f1", _HELP),
        palette.OpenPalette(),
        console.KeepKey(verbs["keep"]),
        recordings.ShowRecordings(),
        console.ToggleQuiet(),
        console.Suspend(),
        console.Quit(),
        everywhere(console.Quit(), "quit_everywhere", "ctrl+q", "Quit, also while typing"),
    )


def _robot_file_commands(verbs: Mapping[str, Verb]) -> Iterator[tuple[Give, Give | None]]:
    """Yield the verb of each command of the robot file, with its opposite for a toggle, or None."""
    for verb in verbs.values():
        if isinstance(verb, Give) and verb.id == verb.given.id:
            off = verbs.get(verb.given.off_word)
            yield verb, off if isinstance(off, Give) else None
