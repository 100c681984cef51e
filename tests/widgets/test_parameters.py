"""An operator edits parameters, by the table and its dialog."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from rich.color import Color
from textual.geometry import Region
from textual.widgets import Input, Static

from archo_tui.base.errors import ArchoError
from archo_tui.robot.state.graph import Parameter
from archo_tui.screen.widgets import parameters_panel
from tests.support.console import FAST, Console, console
from tests.support.night import corners


async def edit(op: Console, name: str, typed: str) -> None:
    """Open the dialog of the first parameter of that name, and submit a value."""
    await op.press("4")
    if name not in op.parameters:
        await op.press("full_stop")
    row = op.parameters.index(name)
    op.send("home", *["down"] * row, "enter")
    await op.until(lambda: op.app.screen.query("#value") and f" {name} " in op.text)
    field = op.app.screen.query_one("#value", Input)
    field.value = ""
    await op.type(typed)
    await op.press("enter")


def _error(op: Console) -> str:
    """What the dialog says is wrong."""
    return str(op.app.screen.query_one(".error", Static).content)


async def undo(op: Console) -> None:
    """Press u when every change is answered; what was set may be seen before that."""
    await op.until(lambda: not op.app.station.edits.is_changing)
    await op.press("u")


async def test_a_parameter_is_edited_mid_route_and_takes_effect() -> None:
    async with console("-p", "feedback_period:=0.2", "-p", "time_scale:=3.0") as op:
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.press("escape")
        await edit(op, "max_speed", "0.4")
        await op.until(lambda: op.app.screen is op.app.main)
        await op.until("0.4 *  double   0.05 .. 2")
        await op.until("0.40 m/s")
        await op.until("set motor_controller max_speed 0.4: max_speed is 0.4, was 0.8")
        await op.press("ctrl+c")


async def test_a_wrong_value_is_said_and_the_dialog_follows_the_value() -> None:
    async with console(*FAST) as op:
        before = op.app.view.snapshot.parameters
        await op.press("4", "full_stop")
        for name, typed, said in (
            ("max_speed", "", "a value is needed (double)"),
            ("max_speed", "fast", "not a number: fast"),
            ("max_speed", "9", "allowed 0.05 .. 2, not 9"),
            ("max_speed", "nan", "not a finite number: nan"),
            ("shelf_count", "1.5", "not a whole number: 1.5"),
            ("drain_min", "50", "drain_min 50 is above drain_max 0.2"),
            ("use_sim_time", "maybe", "not true or false: maybe"),
        ):
            await edit(op, name, typed)
            await op.until(said)
            await op.press("escape")
            await op.until(lambda: op.app.screen is op.app.main)
        assert op.app.view.snapshot.parameters == before

        await op.press("escape")
        await op.press("4")
        op.send("home", *["down"] * op.parameters.index("max_speed"), "enter")
        await op.until("now    0.8")
        await op.app.station.robot.set_parameters("/motor_controller", {"max_speed": 1.25})
        await op.until("now    1.25")
        assert op.app.screen.query_one("#value", Input).value == "0.8"

        await op.press("escape")
        await edit(op, "max_speed", "1")
        await op.until("1.0 *  double")

        await op.press("escape")
        await edit(op, "drain_min", "0.5")
        await op.until("drain_min 0.5 is above drain_max 0.2")
        await op.app.station.robot.set_parameters("/battery_monitor", {"drain_max": 0.6})
        await op.press("left")
        await op.until(lambda: "above drain_max" not in _error(op))
        await op.press("enter")
        await op.until(lambda: not op.app.screen.query("#value"))


async def test_a_low_battery_is_a_word_a_banner_and_one_event_and_clears_above() -> None:
    async with console(*FAST, "-p", "drain_min:=0.0", "-p", "drain_max:=0.0") as op:
        await op.until(lambda: "● GOOD 87.5 %" in op.words)
        await edit(op, "low_battery_threshold", "90")
        await op.until(lambda: "▲ LOW 87.5 %" in op.words)
        await op.until(
            "▲ LOW BATTERY 87.5 %: dock the robot, or press c to charge   (a acknowledge)"
        )
        await op.until("low 90 ")
        await op.until(lambda: "Low battery: 87.5%   x " in op.line("Low battery"))
        assert op.text.count("Low battery") == 1
        await op.press("a")
        await op.until(lambda: "acknowledge)" not in op.text)
        assert "▲ LOW BATTERY 87.5 %" in op.text
        await edit(op, "low_battery_threshold", "86")  # 87.5 is not yet 3 above
        await op.until("low 86 ")
        assert "▲ LOW 87.5 %" in op.words
        await edit(op, "low_battery_threshold", "84.5")
        await op.until(lambda: "● GOOD 87.5 %" in op.words)
        await op.until(lambda: "LOW BATTERY" not in op.text)


async def test_what_a_terminal_could_act_on_is_shown_harmlessly_and_a_long_value_cut() -> None:
    async with console(*FAST) as op:
        dashboard = op.session.host.nodes[1].node
        dashboard.declare_parameter("a[red]name", "\x1b[2Jgone\u202e [bold]x")
        await op.until("a[red]name")
        assert "\x1b" not in op.text
        assert "�[2Jgone" in op.text.replace("  ", "") or "�[2J" in op.text
        await edit(op, "a[red]name", "plain [b]text")
        await op.until(lambda: op.app.screen is op.app.main)
        await op.until("set dashboard a[red]name plain [b]text: ")

        dashboard = op.session.host.nodes[1].node
        dashboard.declare_parameter("much", "9" * 120)
        await op.until("99…")
        assert "99…" in op.line(" much ")


async def test_u_undoes_the_last_change_and_asks_if_another_came_since() -> None:
    async with console(*FAST) as op:
        await op.press("4", "u")
        await op.until("nothing to undo")
        await edit(op, "max_speed", "0.4")
        await op.until("0.4 *  double")
        await edit(op, "max_speed", "0.6")
        await op.until("0.6 *  double")
        await undo(op)
        await op.until("0.4 *  double")
        await undo(op)
        await op.until("0.8    double   0.05 .. 2")
        await op.until("set motor_controller max_speed 0.8: max_speed is 0.8, was")

        await edit(op, "max_speed", "0.4")
        await op.until("0.4 *  double")
        await op.app.station.robot.set_parameters("/motor_controller", {"max_speed": 1.25})
        await op.until("1.25 *  double")
        await op.press("4")
        await undo(op)
        await op.until("max_speed has since changed to 1.25. Restore 0.8?")
        await op.press("enter")
        await op.until(lambda: op.app.screen is op.app.main)
        assert "1.25 *  double" in op.text
        await undo(op)
        await op.until("Restore 0.8?")
        await op.press("tab", "enter")
        await op.until("0.8    double   0.05 .. 2")


async def test_a_filter_finds_by_name_and_says_in_the_title_what_it_hides() -> None:
    async with console(*FAST) as op:
        await op.press("4", "slash")
        await op.type("speed")
        await op.until(lambda: "low_battery_threshold" not in op.text)
        assert "max_speed" in op.text
        await op.press("enter", "enter")  # the first leaves the field
        await op.until(" motor_controller max_speed ")
        await op.press("escape", "slash", "escape")
        await op.until("low_battery_threshold")

        await op.press("escape")
        await op.press("4", "slash", *"warp", "enter")
        await op.until("nothing contains warp")
        await op.press("slash", "escape", "d")
        await op.until("nothing differs from the start")
        await op.press("d", "6", "r")
        await op.until("✓  reset encoder")
        await op.press("slash", *"warp", "enter")
        await op.until("Nothing contains warp at WARN and above.")
        await op.press("slash", "escape")
        await op.until("✓  reset encoder")
        assert "Nothing contains" not in op.text

        await op.press("escape")
        await op.press("4", "slash", *"[b", "enter")
        await op.until("4 Parameters   / [b: 0 of ")

        await op.press("escape")
        await op.press("4", "slash", *"max", "enter")
        await op.until("4 Parameters   / max: ")
        title = op.app.main.parameters.render_lines(Region(0, 0, 60, 1))[0]
        (said,) = [part for part in title if "/ max: " in part.text]
        assert said.style is not None
        assert said.style.color == Color.parse(op.app.theme_variables["warning"].lower())
        await op.press("escape")
        await op.until(lambda: "/ max:" not in op.text)
        await op.until("low_battery_threshold")
        await op.press("d")
        await op.until("4 Parameters   what differs from the start")


async def choose_file(op: Console, key: str, path: str) -> None:
    """Name a file in the dialog that a key opens."""
    await op.press("4", key)
    await op.until("ROS parameter file")
    op.app.screen.query_one("#path", Input).value = path
    await op.press("enter")


async def test_parameters_are_saved_and_loaded_with_a_preview(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = here / "f.yaml"
    async with console(*FAST) as op:
        before = op.app.view.snapshot.parameters
        file.write_text("motor_controller:\n  ros__parameters:\n    max_speed: 9.0\n")
        for path, said in (
            (str(file), "allowed 0.05 .. 2"),
            ("~nosuchuser/x", "no home folder is known for ~nosuchuser"),
        ):
            await choose_file(op, "ctrl+o", path)
            await op.until(said)
            await op.press("escape")
            await op.until(lambda: op.app.screen is op.app.main)
        assert op.app.view.snapshot.parameters == before

        file = here / "mine.yaml"
        await edit(op, "max_speed", "0.4")
        await op.until("0.4 *  double")
        await choose_file(op, "ctrl+s", str(file))
        await op.until(file.exists)
        await op.until(lambda: op.app.screen is op.app.main)
        await undo(op)
        await op.until("0.8    double   0.05 .. 2")
        await choose_file(op, "ctrl+o", str(file))
        await op.until("motor_controller max_speed: 0.8, would be 0.4")
        await op.press("tab", "enter")
        await op.until(lambda: op.text.count("max_speed is 0.4, was 0.8") == 2)
        await undo(op)
        await op.until("0.8    double   0.05 .. 2")

        file = here / "mine.yaml"
        file.write_text("precious")
        await choose_file(op, "ctrl+s", str(file))
        await op.until("already exists: press enter again to overwrite")
        assert file.read_text() == "precious"
        await op.press("enter")
        await op.until(lambda: "max_speed" in file.read_text())

        go_on = asyncio.Event()

        async def slow(*_: Any) -> Any:
            await go_on.wait()
            raise ArchoError("no such file")

        await op.press("4", "ctrl+o")
        dialog: Any = op.app.screen
        monkeypatch.setattr("archo_tui.verbs.parameters.in_daemon", slow)
        await op.press("enter", "escape")
        assert op.app.screen is op.app.main
        go_on.set()
        await op.settle()
        dialog.show_message("too late")  # which says nothing
        assert op.app.is_running


async def test_backspace_offers_the_start_and_space_switches_a_boolean() -> None:
    async with console(*FAST) as op:
        await op.press("4", "d")
        await op.until("nothing differs from the start")
        await op.press("d", "slash", *"max_speed", "enter", "enter", "ctrl+u", *"0.5", "enter")
        await op.until("0.5 *")
        await op.press("slash", "escape", "d")
        await op.until("0.5 (was 0.8)")
        assert "wheel_radius" not in op.text
        await op.press("backspace", "enter")
        await op.until("nothing differs from the start")

        await op.press("d")
        await op.press("4", "slash", *"sim_time", "enter", "space")
        await op.until("set battery_monitor use_sim_time true: ")
        await op.until("true *")
        await op.press("space")
        await op.until(lambda: "true *" not in op.text)
        await op.press("slash", "ctrl+u", *"max_speed", "enter", "space")
        await op.until("the selected parameter is not a boolean")


LABELS = ["a, b", "yes", "", "it's\n\u202e"]


async def test_a_value_that_is_sent_untouched_stays_and_no_mark_is_sent() -> None:
    values = {"long": "x" * 600, "lines": "two\nlines\u202e", "several": LABELS}
    made: list[Node] = []

    def labelled(**options: Any) -> Node:
        made.append(Node("labelled", **options))
        for name, value in values.items():
            made[0].declare_parameter(name, value)
        return made[0]

    async with console(node_makers=[labelled], wait=False) as op:

        async def open_value(name: str) -> None:
            await op.until(lambda: op.app.view.snapshot.parameter(name) is not None)
            await op.press("4")
            op.send("home", *["down"] * op.parameters.index(name), "enter")
            await op.until(lambda: op.app.screen.query("#value"))

        for name, value in values.items():
            await open_value(name)
            await op.press("enter")
            await op.until(f"set labelled {name}")
            assert made[0].get_parameter(name).value == value
            assert op.app.view.snapshot.parameter(name).value == value  # type: ignore[union-attr]
        await open_value("lines")
        await op.press("end", "!", "enter")
        await op.until("stands for what cannot be shown: type it again")
        assert made[0].get_parameter("lines").value == values["lines"]


@pytest.mark.parametrize("size", corners([(80, 24)], [(120, 36)]))
async def test_where_the_table_scrolls_every_bound_keeps_its_last_digit(
    size: tuple[int, int],
) -> None:
    bounds = {"route_length": "0.1 .. 1000", "wheel_radius": "0.01 .. 0.5"}
    async with console(*FAST, size=size) as op:
        await op.press("4", "full_stop")
        for name, allowed in bounds.items():
            await op.press("home")
            names = op.parameters
            op.send(*["down"] * names.index(name))
            await op.until(lambda name=name: name in op.text)  # type: ignore[misc]
            assert re.search(rf" {allowed}\W", op.line(name))


def test_a_range_without_room_is_cut_by_an_ellipsis() -> None:
    low, high = -1234567890123, 1234567890123
    wide = Parameter("/n", "p", "integer", 5, 5, low=low, high=high)
    for width in range(58, 140):
        columns = parameters_panel.parameter_columns([wide], width, 1)
        ((line, _),) = parameters_panel.parameter_lines(wide, width, columns)
        whole = f"{low} .. {high}"
        assert len(line) <= width
        if columns[4]:
            assert line.endswith((whole, "…"))
        if width >= 95:
            assert line.endswith(whole)


@pytest.mark.parametrize(
    ("count", "rows", "described"), [(20, 40, True), (20, 39, False), (2, 4, True), (2, 3, False)]
)
def test_descriptions_are_lines_if_all_have_room(count: int, rows: int, described: bool) -> None:
    speed = Parameter("/motor", "speed", "double", 0.5, 0.5, "m/s along the route")
    columns = parameters_panel.parameter_columns([speed] * count, 80, rows)
    lines = parameters_panel.parameter_lines(speed, 80, columns)
    assert len(lines) == 1 + described
    if described:
        below = lines[1][0]
        assert below.strip() == "m/s along the route"
        assert below.index("m/s") == lines[0][0].index("speed")


def test_a_parameter_without_a_description_has_one_line() -> None:
    plain = Parameter("/motor", "speed", "double", 0.5, 0.5)
    columns = parameters_panel.parameter_columns([plain], 80, 30)
    assert len(parameters_panel.parameter_lines(plain, 80, columns)) == 1
