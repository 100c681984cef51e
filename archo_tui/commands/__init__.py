"""The one registry of commands: keys, footer, `?`, palette, buttons and README come from it."""

from __future__ import annotations

from archo_tui.commands import anything, console, events, history, nodes, parameters, robot
from archo_tui.commands.base import Command
from archo_tui.robots.model import Robot


def registry(described: Robot) -> tuple[Command, ...]:
    """Every command of the console for the robot that a file describes."""
    first, *others = described.goals or (None,)
    titles = (
        "Battery",
        "Motion" if described.motion is None else described.motion.title,
        "Goal" if first is None else first.title,
        "Parameters",
        "Nodes",
        "Events",
        "History",
    )
    return (
        robot.Go(first),
        robot.Cancel(),
        robot.CancelAll(),
        robot.Continue(),
        robot.Drop(),
        robot.StopNow(described.stop),
        robot.GiveUpStop(),
        robot.Release(described.stop),
        *(robot.Give(command) for command in described.commands),
        *(robot.SendGoal(kind) for kind in others if kind is not None),
        anything.AnyGoal(),
        anything.AnyService(),
        anything.KeepRobot(),
        console.Acknowledge(),
        console.ShowAlarms(),
        *(console.Panel(number, title) for number, title in enumerate(titles, 1)),
        parameters.Edit(),
        parameters.Restore(),
        parameters.Switch(),
        parameters.OnlyChanged(),
        parameters.Filter(),
        parameters.Undo(),
        parameters.Save(),
        parameters.Load(),
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
        console.ShowHelp(),
        console.ShowHelpEverywhere(),
        console.Palette(),
        console.Quiet(),
        console.Suspend(),
        console.Quit(),
        console.QuitEverywhere(),
    )
