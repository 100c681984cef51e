"""The one registry of commands: keys, footer, `?`, palette, buttons and README come from it."""

from __future__ import annotations

from archo_tui.commands import console, events, nodes, parameters, robot
from archo_tui.commands.base import PANELS, Command

COMMANDS: tuple[Command, ...] = (
    robot.Go(),
    robot.Cancel(),
    robot.Stop(),
    robot.Release(),
    robot.Reset(),
    robot.Charge(),
    console.Acknowledge(),
    console.ShowAlarms(),
    *(console.Panel(number) for number in range(1, len(PANELS) + 1)),
    parameters.Edit(),
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
    console.ShowHelp(),
    console.Palette(),
    console.Suspend(),
    console.Quit(),
    console.QuitEverywhere(),
)
