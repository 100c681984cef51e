"""A robot of another make, from its file: nested fields, a battery of 0 .. 1, goals, no STOP."""

from __future__ import annotations

import asyncio
import math
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("depot_interfaces")

from action_msgs.srv import CancelGoal
from depot_interfaces.action import Dock
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

import archo_tui
from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from archo_tui.robot_file.load import load
from tests.robots.rover import Rover
from tests.support.console import Console, console, console_with
from tests.support.plain import operated, plain
from tests.support.quiet import ended, until
from tests.support.robot import robot
from tests.support.shells import raw, served, typed
from tests.support.stand_in import Made

FILE = Path(__file__).with_name("rover.yaml")


def rover(file: Path = FILE, **options: Any) -> AbstractAsyncContextManager[tuple[Console, Rover]]:
    """The console, and the rover's node."""
    return console_with(Rover, "go_to", "dock", "odom", robot=file, **options)


@pytest.mark.waits
async def test_its_readings_are_shown_in_the_consoles_units_as_they_change() -> None:
    async with rover() as (op, node):
        await op.until("75.0 %  14.5 V")
        assert "discharging" in op.text
        assert "low 25" in op.text
        await op.until("0.00 m/s")
        await op.until("● IDLE")
        await op.until(lambda: "Temperature 31.5 °C" in op.words)
        await op.until("● IDLE")
        node.turning = -0.4
        await op.until("▶ MOVING")
        assert "0.00 m/s" in op.text
        node.turning = 0.0
        await op.until("● IDLE")
        node.speed, node.is_held = -0.3, True
        await op.press("g", "1", "enter", "2", "enter", "0", "enter")
        await op.until("-0.30 m/s")
        await op.until("▶ MOVING")
        await op.until(lambda: "Temperature 31.5 °C" in op.words)
        node.celsius = 71.0
        await op.until(lambda: "▲ Temperature 71 °C, above 60" in op.words)
        await op.until("TEMPERATURE 71 °C: above 60")
        node.celsius = math.nan
        await op.until("? Temperature UNREADABLE nan")
        await op.until("discharging")
        node.is_full = True
        await op.until("neither charging nor discharging")
        assert "empty in" not in op.text


async def test_a_goal_of_nested_fields_is_typed_field_by_field_beside_what_was_recalled() -> None:
    async with rover() as (op, node):
        node.is_held = True
        await op.press("g", *"1.5", "enter", *"-2", "enter", *"90", "enter")
        await op.until("MOVING to x 1.5, y -2.0, yaw 90.0")
        await op.until("▶ MOVING")
        await op.until("m left of 5.0 m")
        await op.press(*"3", "enter", *"4")
        typed = [[field.value for field in op.app.main.goal.fields]]
        for key in ("up", "up", "down", "down"):
            await op.press(key)
            typed.append([field.value for field in op.app.main.goal.fields])
        draft, sent = ["3", "4", ""], ["1.5", "-2", "90"]
        assert typed == [draft, sent, sent, draft, draft]
        node.is_held = False
        await op.until("✓ ARRIVED")
        target = node.heard[0]
        assert (target.frame_id, target.pose.position.x, target.pose.position.y) == ("map", 1.5, -2)
        assert target.pose.orientation.z == pytest.approx(math.sqrt(0.5))
        assert target.pose.orientation.w == pytest.approx(math.sqrt(0.5))


async def test_what_is_typed_into_fields_or_as_a_key_is_sent_or_said() -> None:
    async with rover() as (op, node):
        await op.press("g", "1", "enter", "2", "enter", *"400", "enter")
        await op.until("yaw: at most 360, not 400")
        node.is_held = True
        await op.press("backspace", "enter")  # the field has the focus
        await op.until("MOVING to x 1.0, y 2.0, yaw 40.0")
        node.is_held = False
        await op.until("✓ ARRIVED")
        node.is_held = True
        op.send("g", *"123456789.5", "enter", "2", "enter", *"90", "enter")
        await op.until("MOVING to x 123456789.5, y 2.0, yaw 90.0")
        node.is_held = False
        await op.until("✓ ARRIVED")
        node.is_held = True
        op.send(*"1", "enter", *"-2.25", "enter", "7", "enter", *"99", "enter")
        await op.until("MOVING to x 1.0, y -2.25, yaw 7.0")
        assert op.app.main.goal.fields[0].value == "99"
        target = node.heard[1].pose.position
        assert (target.x, target.y) == (123456789.5, 2.0)
        node.is_held = False
        await op.until("✓ ARRIVED")
        await op.press("escape", "escape", "D")  # It docks and undocks by keys of its file.
        await op.until("is_docked true")
        await op.until("CHARGING")
        assert node.docked
        await op.press("U")
        await op.until("discharging")
        await op.until("undock succeeded: is_docked false")


async def test_numbers_of_the_file_say_what_is_low_and_how_long_the_way_is(tmp_path: Path) -> None:
    file = tmp_path / "rover.yaml"
    link = "{node: bms, parameter: none_such, otherwise: 25.0}"
    remaining = "remaining: {field: distance_remaining, unit: m"
    text = FILE.read_text().replace(remaining, f"{remaining}, length: 20")
    file.write_text(text.replace(link, "80"))
    async with rover(file) as (op, node):
        await op.until("▲ LOW")
        await op.until("low 80")
        await op.until("LOW BATTERY")
        node.is_held = True
        await op.press("g", *"1.5", "enter", *"-2", "enter", *"90", "enter")
        await op.until("The battery is low, 75.0 %. Send all the same?")
        await op.press("y")
        await op.until("m left of 20.0 m")


async def test_a_field_that_the_type_has_not_is_said_with_file_and_line(tmp_path: Path) -> None:
    file = tmp_path / "rover.yaml"
    wrong = FILE.read_text().replace("field: fraction", "field: fractoin")
    file.write_text(wrong.replace("form:\n", "form:\n      target.pose.x: {label: z}\n"))
    async with rover(file) as (op, _):
        fault = "depot_interfaces/msg/Charge has no field fractoin (nearest: fraction)"
        await op.until(lambda: f"{file}:8: {fault}" in op.app.view.snapshot.faults.values())
        fault = (
            "depot_interfaces/action/GoTo Goal has no field target.pose.x (nearest: target.pose)"
        )
        await op.until(lambda: f"{file}:26: {fault}" in op.app.view.snapshot.faults.values())
        await op.press("g", "1", "enter", "1", "enter", "1", "enter", "1", "enter")
        await op.until("target.pose.x (nearest")
        assert op.app.view.snapshot.goal is None
        assert "GOOD" not in op.text


async def test_it_is_operated_line_by_line() -> None:
    code, text = await plain(
        "status\ngo x=1 y=2\ngo x=1 y=2 z=3\ngo x=010 y=1_0 yaw=0\ngo x=010 y=1:30 yaw=0\n"
        "go x=1 y=2 yaw=nan\ngo x=1 y=2 yaw=0 x=3\nstop\ngo x=010 y=2 yaw=0\n",
        Rover,
        robot=FILE,
    )
    assert code == 1
    for part in (
        "Temperature, 31.5 °C",
        "goal No goal yet. Type go, then x, y and yaw, each with an equals sign and its value.\n",
        "failed: go: expected x=... y=... yaw=...\n",
        "failed: go: expected x=... y=... yaw=..., not z=3",
        "failed: stop: Rover has no STOP: use the hardware stop",
        "failed: go: y: not a number: 1_0",
        "failed: go: y: not a number: 1:30",
        "failed: go: expected x=... y=... yaw=..., not x=3",
        "failed: go: yaw: at least -360, not nan",
        "go to pose x 10.0, y 2.0, yaw 0.0: accepted",
        "goal ARRIVED",
    ):
        assert part in text, text


@pytest.mark.real_time
async def test_what_an_assistant_writes_hides_nothing_and_looks_like_no_other_value(
    tmp_path: Path,
) -> None:
    named = tmp_path / "named.yaml"  # the frame is asked for, too
    text = FILE.read_text().replace("    fixed: {target.frame_id: map}\n", "")
    named.write_text(
        text.replace("    form:\n", "    form:\n      target.frame_id: {label: frame}\n")
    )
    place = {f"target.pose.position.{axis}": 1.5 for axis in "xy"}
    place["target.pose.orientation"] = 0
    async with rover(named, remote=True) as (op, node):
        assistant = await raw()

        async def asks(frame: str) -> str:
            wanted = {"kind": "go", "values": {"target.frame_id": frame, **place}}
            assistant.send({"id": 1, "assistant": True, "ask": wanted})
            return str((await assistant.result())["text"])

        unseen = (
            "\u00ad\u034f\u115f\u2800\u3164\ufe0f\u00a0\u3000\u200b\u202e\ufeff\U000e0100\n\x1b"
        )
        for text in (*(f"ma{char}p" for char in unseen), "map ", " map", "m  ap"):
            assert "or some that are invisible" in await asks(text), ascii(text)
        said = await asks("map, x 9")
        assert said.endswith('go to pose frame "map, x 9", x 1.5, y 1.5, yaw 0.0')
        await op.press("A")
        await op.until('target.frame_id: "map, x 9"')
        assert node.heard == []
        assistant.close()


# A file that asks of a type what it does not take: said by line, and nothing is sent.
GOAL = """version: 1
goals:
  - id: navigate
    title: Go
    action: go_to
    type: depot_interfaces/action/GoTo
    form:
      target.pose.position.x: {label: x}
      CHANGED
    fixed: {FIXED}
"""
X, TURN, FRAME = "target.pose.position.x", "target.pose.orientation", "target.frame_id"
MISFITS = [
    (f"{FRAME}: {{label: y, low: 1}}", "", 9, f"{FRAME} is string: low and high are for numbers"),
    (f"{X[:-1]}y: {{convert: yaw}}", "", 9, "is double: convert: yaw is for a quaternion"),
    (f"{TURN}: {{label: y}}", "", 9, "is depot_interfaces/Quaternion: name one of its fields"),
    (f"{X[:-1]}y: {{}}", f"{X[:-1]}z: far", 3, "fixed: target.pose.position.z: "),
    (f"{X[:-1]}y: {{}}", f"{X[:-2]}: {{z: 1}}, {X[:-1]}z: 1", 3, "z is given twice, also by "),
]


@pytest.mark.parametrize(("changed", "fixed", "line", "said"), MISFITS)
async def test_a_form_that_does_not_fit_is_said_and_nothing_is_sent(
    here: Path, changed: str, fixed: str, line: int, said: str
) -> None:
    file = here / "robot.yaml"
    file.write_text(GOAL.replace("CHANGED", changed).replace("FIXED", fixed))
    made = Made(Rover)
    code, out = await plain("go x=1 y=2\ngo x=1 y=[2]\nstatus\n", made, robot=file)
    assert code == 1
    warned = [text for text in out.splitlines() if "WARN console: " in text]
    assert [text for text in warned if f"{file}:{line}: " in text and said in text], out
    assert made.node.heard == []
    assert "Traceback" not in out


# Its file names no STOP: its key cancels every goal, and never calls that a STOP.

GO = load(FILE).goals[0]
THERE = {"target.pose.position.x": 9.0, "target.pose.position.y": 0.0}
NONE = "Rover has no STOP: use the hardware stop (this is not a STOP: "


async def moving(it: Robot) -> None:
    """Have the rover drive."""
    await until(lambda: {"go_to", "dock", "undock"} <= it.snapshot.offered)
    turned = {"target.pose.orientation": 0.0}
    assert (await ended(it.send(GO, {**THERE, **turned}))).ok
    await until(lambda: phase_of(it) is Phase.MOVING)


def phase_of(it: Robot) -> Phase | None:
    return None if it.snapshot.goal is None else it.snapshot.goal.phase


async def test_every_goal_is_cancelled_and_that_is_called_no_stop() -> None:
    async with robot(Rover, robot=FILE) as it:
        await moving(it)
        it.stops.register()
        outcome = await ended(it.emergency_stop())
        assert outcome == (Code.NOT_OFFERED, f"{NONE}cancelling 1 goal)")
        await until(lambda: phase_of(it) is Phase.CANCELLED)
        assert it.stops.are_answered
        assert not it.snapshot.is_stopped


class Silent(Node):
    """Serves an action that the robot file does not name, and answers no cancel."""

    def __init__(self, **options: Any) -> None:
        super().__init__("silent", **options)
        self.asked = 0
        self.awake: Future[bool] = Future()
        group, impl = ReentrantCallbackGroup(), Dock.Impl
        self.create_publisher(impl.FeedbackMessage, "asleep/_action/feedback", 10)
        self.create_service(impl.SendGoalService, "asleep/_action/send_goal", lambda *_: None)
        name = "asleep/_action/cancel_goal"
        self.create_service(CancelGoal, name, self.cancel, callback_group=group)

    async def cancel(self, _: Any, response: Any) -> Any:
        self.asked += 1
        await self.awake
        return response


async def test_a_server_that_does_not_answer_keeps_no_other_goal_running() -> None:
    made = Made(Silent)
    async with robot(Rover, made, robot=FILE) as it:
        await moving(it)
        await until(lambda: "/asleep" in it.snapshot.actions)
        it.stops.register()
        stop = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: phase_of(it) is Phase.CANCELLED)
        assert not stop.done()
        it.stops.register()  # One that is read meanwhile is answered with it.
        outcome = await ended(stop)
        assert it.stops.are_answered
        assert outcome.text == f"{NONE}no answer to the cancel in 2 s: /asleep)"
        assert made.node.asked == 1
        made.node.awake.set_result(True)


async def test_goals_that_wait_are_held_behind_it() -> None:
    made = Made(Rover)
    async with operated(made, robot=FILE) as person:
        person.type("go x=1 y=2 yaw=0\ngo x=3 y=4 yaw=0\n")
        await person.until("goal MOVING")
        await person.until("queue: ")
        person.type("stop\n")
        await person.until(f"failed: stop: {NONE}cancelling 1 goal)")
        await person.until("goal CANCELLED")
        await person.until("held")
        assert [target.pose.position.x for target in made.node.heard] == [1.0]
        assert await person.end("") == 1


@pytest.mark.real_time
async def test_a_shell_and_python_are_told_that_it_was_no_stop() -> None:
    async with served(Rover, robot=FILE):
        said = await typed("stop")
        assert said.code != 0
        assert f"{NONE}none was cancelled)" in said.err

        def stop() -> str:
            with archo_tui.connect() as rover:
                try:
                    rover.stop()
                except archo_tui.NotDone as failed:
                    return str(failed)
            return "stopped"

        assert f"{NONE}none was cancelled)" in await asyncio.to_thread(stop)


async def test_its_screen_names_what_the_key_does_and_nothing_that_releases() -> None:
    async with console_with(Rover, "go_to", robot=FILE) as (op, node):
        await op.until("^x cancel all")
        assert "no STOP" in op.line(" Rover ")
        assert "Cancel all" in op.line("Cancel all")
        assert "STOP" not in op.text.replace("no STOP", "")
        assert "R release" not in op.text
        node.is_held = True
        await op.press("g", *"1.5", "enter", *"-2", "enter", *"90", "enter")
        await op.until("m left of")
        await op.press("ctrl+x")
        await op.until("Rover has no STOP: use the hardware stop")
        await op.until("this is not a STOP")
        await op.until("✗ CANCELLED")
        assert "STOPPED" not in op.text


@pytest.mark.parametrize("size", [(80, 24), (120, 36)])
async def test_the_longest_title_of_a_command_leaves_the_stop_its_place(
    size: tuple[int, int], here: Path
) -> None:
    file = here / "robot.yaml"
    file.write_text(
        "name: Long\nstop: {service: halt}\ncommands:\n"
        f"  - {{id: map, title: Save {'the whole map ' * 9}, key: m, service: map}}\n"
    )
    async with console(robot=file, node_makers=[Rover], size=size, wait=False) as op:
        await op.until("Save the")
        assert " STOP " in op.line("Save the")
