"""Operate another robot: the console starts again, for another namespace."""

from __future__ import annotations

from dataclasses import replace
from typing import Any
from unittest.mock import patch

from archo_tui.robot.state.snapshot import Latch, OpenStop
from archo_tui.robot.stop.gate import HOLDS, OPEN_STOP, UNCERTAIN
from tests.support.quiet import Quiet
from tests.support.states import MOTOR, NORMAL
from tests.support.stub import stub_app


async def test_a_robot_that_was_seen_is_chosen_and_the_console_restarts() -> None:
    app = stub_app(NORMAL._replace(other_namespaces=("/tb1", "/tb2")))
    app.station.attached = True
    restarts: list[str] = []
    app.restart = restarts.append  # type: ignore[method-assign, assignment]
    async with app.run_test() as pilot:
        quiet = Quiet(app)
        app.action_command("other_robot")
        await quiet.settle()
        await pilot.press("down", "enter")
        await quiet.settle()
    assert restarts == ["operate the robot in /tb2"]
    assert app.station.next_namespace == "/tb2"


async def test_it_is_refused_while_the_robot_is_needed_here() -> None:
    elsewhere = NORMAL._replace(other_namespaces=("/tb1",))
    app = stub_app(elsewhere)
    command = next(one for one in app.registry if one.id == "other_robot")
    assert "--attach" in command.disabled_reason(app)
    app.station.attached = True
    robot: Any = app.station.robot
    assert command.disabled_reason(app) == ""
    robot.snapshot = elsewhere._replace(open_stop=OpenStop(0.0))
    assert command.disabled_reason(app) == OPEN_STOP
    robot.snapshot = elsewhere
    robot.stops.register()  # A STOP that no snapshot shows yet.
    assert command.disabled_reason(app) == OPEN_STOP
    robot.stops.answered = robot.stops.count
    robot.snapshot = elsewhere._replace(motion=replace(MOTOR, stopped=True))
    assert command.disabled_reason(app) == HOLDS
    robot.snapshot = elsewhere._replace(latch=Latch.UNCERTAIN)
    assert command.disabled_reason(app) == UNCERTAIN
    robot.snapshot = NORMAL._replace(other_namespaces=())
    assert command.disabled_reason(app) == "no other namespace has nodes"


async def test_a_stop_behind_the_list_keeps_the_console_with_its_robot() -> None:
    app = stub_app(NORMAL._replace(other_namespaces=("/tb1", "/tb2")))
    app.station.attached = True
    restarts: list[str] = []
    with patch.object(app, "restart", restarts.append):
        async with app.run_test() as pilot:
            quiet = Quiet(app)
            app.action_command("other_robot")
            await quiet.settle()
            robot: Any = app.station.robot
            robot.snapshot = robot.snapshot._replace(open_stop=OpenStop(0.0))
            await pilot.press("enter")
            await quiet.settle()
    assert restarts == []
    assert app.station.next_namespace == ""


async def test_a_stop_just_behind_the_choice_keeps_the_robot_for_good() -> None:
    app = stub_app(NORMAL._replace(other_namespaces=("/tb1", "/tb2")))
    app.station.attached = True
    async with app.run_test() as pilot:
        robot: Any = app.station.robot
        app.station.operate("/tb2")
        robot.snapshot = robot.snapshot._replace(open_stop=OpenStop(0.0))
        await Quiet(app).settle()
        assert app.is_running
        robot.put(NORMAL)
        await pilot.press("5", "ctrl+r")
        await Quiet(app).settle()
        assert app.is_running
    assert app.station.next_namespace == ""
