"""The one registry of commands: keys, footer, `?`, palette, buttons, docs/keys.md come from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from archo_tui.commands import (
    anything,
    console,
    events,
    graph,
    history,
    nodes,
    palette,
    parameters,
    recordings,
    robot,
)
from archo_tui.commands.base import Command, Speak
from archo_tui.robot_file.model import RobotFile
from archo_tui.verbs import verbs as vocabulary
from archo_tui.verbs.base import Verb
from archo_tui.verbs.goals import Go
from archo_tui.verbs.services import Give


def registry(described: RobotFile, spoken: Mapping[str, Verb] | None = None) -> tuple[Command, ...]:
    """Every command of the console for the robot that a file describes.

    `spoken` are its verbs; without them no command can be run, and each has its key and words.
    """
    verbs = vocabulary(described, {}) if spoken is None else spoken
    goals = [verb for verb in verbs.values() if isinstance(verb, Go)]
    first = described.goals[0] if described.goals else None
    titles = (
        "Battery",
        "Motion" if described.motion is None else described.motion.title,
        "Goal" if first is None else first.title,
        "Parameters",
        "Nodes",
        "Events",
        "History",
        "Graph",
    )
    return (
        robot.Go(goals[0] if goals else None),
        robot.Cancel(verbs["cancel"]),
        robot.CancelAll(verbs["cancel"]),
        robot.Continue(verbs["continue"]),
        robot.Skip(verbs["skip"]),
        robot.StopNow(verbs["stop"]),
        Speak(verbs["give_up_stop"]),
        robot.Release(verbs["release"]),
        *(robot.Give(on, off) for on, off in _given(verbs)),
        *(robot.SendGoal(goal) for goal in goals[1:]),
        anything.AnyGoal(verbs["send_goal"]),
        anything.AnyService(verbs["call"]),
        anything.KeepRobot(),
        console.Acknowledge(verbs["ack"]),
        console.ShowAlarms(),
        *(console.Panel(number, title) for number, title in enumerate(titles, 1)),
        parameters.Edit(),
        parameters.Restore(),
        parameters.Switch(),
        parameters.OnlyChanged(),
        parameters.RosOwn(),
        parameters.Filter(),
        parameters.Undo(verbs["undo"]),
        parameters.Save(verbs["save"]),
        parameters.Load(verbs["load"]),
        nodes.StartStop(),
        nodes.Copy(),
        nodes.Details(),
        events.Level(),
        events.Search(),
        events.CopyCommand(),
        events.FullScreen(),
        events.WholeEvent(),
        events.SaveEvents(),
        history.ShowHistory(),
        history.LookBack(-1),
        history.LookBack(1),
        graph.Resource(),
        console.ShowHelp(),
        console.ShowHelpEverywhere(),
        palette.Palette(),
        console.Keep(verbs["keep"]),
        recordings.ShowRecordings(),
        console.Quiet(),
        console.Suspend(),
        console.Quit(),
        console.QuitEverywhere(),
    )


def _given(verbs: Mapping[str, Verb]) -> Iterator[tuple[Give, Give | None]]:
    """The commands of the robot file, each with its other way where it is a toggle."""
    for verb in verbs.values():
        if isinstance(verb, Give) and verb.id == verb.given.id:
            off = verbs.get(verb.given.off_word)
            yield verb, off if isinstance(off, Give) else None
