"""Enter on a topic: its fields live and as texts, what is plotted, and which side is to change."""

from __future__ import annotations

import math
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from itertools import count
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Float32, Float32MultiArray, Float64, String
from textual.geometry import Region
from textual.screen import Screen

from archo_tui.robot.topics.rows import FieldKind, FieldView, TopicView
from archo_tui.screen.commands import graph
from archo_tui.screen.commands.alarms import AlarmList
from archo_tui.screen.terminal.ascii import in_ascii
from archo_tui.text.topic import (
    field_columns,
    field_line,
    range_text,
    sparkline,
    summary,
    topic_plots,
    value_text,
)
from tests.support import clock
from tests.support.clock import TIME
from tests.support.console import Console, console
from tests.support.front import Front, front_of, reset_main
from tests.support.robot import hearing
from tests.support.states import plain_text

_DRAW = Screen._compositor_refresh


class Lidar(Node):
    """It publishes best effort."""

    def __init__(self, **options: Any) -> None:
        super().__init__("lidar", **options)
        self._scan = self.create_publisher(String, "scan", qos_profile_sensor_data)


class Viewer(Node):
    """It asks for reliable messages that are kept."""

    def __init__(self, **options: Any) -> None:
        super().__init__("viewer", **options)
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, "scan", lambda _: None, qos)


class Counting(Node):
    """It publishes something of a number that counts, at 10 Hz."""

    def __init__(self, name: str, kind: Any, data: Callable[[int], Any], **options: Any) -> None:
        super().__init__(name, **options)
        numbers, publisher = count(1), self.create_publisher(kind, name, 10)
        self.create_timer(0.1, lambda: publisher.publish(kind(data=data(next(numbers)))))


COUNT = partial(Counting, "count", Float32, lambda number: number / 2)
STEPS = partial(Counting, "steps", Float32MultiArray, lambda number: [float(number)] * 30)
EXTREME = partial(Counting, "extreme", Float64, lambda number: 1.7e308 * (-1) ** number)


async def open_topic(op: Console, name: str) -> None:
    """Open the dialog of a topic by the Graph."""
    await op.until(lambda: any(r.name == name for r in op.app.view.snapshot.resources))
    await op.press("8", "home")
    while not (row := op.app.main.graph.selected) or row.resource.name != name:
        await op.press("down")
    await op.press("enter")


async def test_fields_follow_the_topic_while_it_is_open_unless_frozen() -> None:
    async with console(node_makers=[COUNT], wait=False) as op:
        await open_topic(op, "/count")
        await op.until("types and QoS of all of them fit")
        await op.until("10.0 Hz   80 B/s")

        def cells() -> list[str]:
            return op.line("┃   data").split()

        await op.until(lambda: cells()[4:6] == ["..", cells()[2]])
        await op.press("space")
        await op.until("frozen")
        frozen = op.line("┃   data")
        await op.at(op.app.station.clock.monotonic() + 3)
        assert op.line("┃   data") == frozen
        assert "10.0 Hz   80 B/s" in op.text
        await op.press("space")
        await op.until(lambda: op.line("┃   data") != frozen)
        counter = op.session.host.nodes[0].node
        assert counter.count_subscribers("/count") == 1
        await op.press("escape")
        await op.until(lambda: counter.count_subscribers("/count") == 0)


async def test_ends_that_do_not_fit_are_named_and_the_greatest_numbers_plotted() -> None:
    async with console(node_makers=[Lidar, Viewer, EXTREME], wait=False) as op:
        await open_topic(op, "/scan")
        await op.until(lambda: "from /lidar BEST_EFFORT, VOLATILE" in op.words)
        await op.until(lambda: "to /viewer RELIABLE, TRANSIENT_LOCAL" in op.words)
        await op.until("viewer hears nothing of lidar on /scan: it asks for RELIABLE")
        await op.until("Publish RELIABLE, or")
        await op.press("escape", "escape")
        await open_topic(op, "/extreme")
        await op.until("-1.7e+308 .. 1.7e+308")
        await op.until(lambda: "█" in op.line("┃   data"))
        await op.press("p")
        await op.until("60 s ago")
        await op.until("-1.7e+308┤")
        assert "cannot be drawn" not in op.text


async def test_what_cannot_be_drawn_says_so_and_the_screen_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def break_down(*_: object) -> None:
        raise ZeroDivisionError("nothing to divide")

    why = "✗ cannot be drawn: ZeroDivisionError: nothing to divide"
    monkeypatch.setattr(graph, "field_line", break_down)
    async with console(node_makers=[COUNT], wait=False) as op:
        await open_topic(op, "/count")
        await op.until(why)
        await op.until("10.0 Hz   80 B/s")
        monkeypatch.setattr(graph, "summary", break_down)
        await op.until(lambda: op.text.count("✗ cannot be drawn") == 2)
        await op.press("escape")
        await op.until(lambda: "cannot be drawn" not in op.text)
        await op.press("escape", "A")
        monkeypatch.setattr(AlarmList, "show_view", break_down)
        await op.until(f"AlarmList {why}")
        await op.press("escape", "ctrl+x")
        await op.until("STOP")


class Opened(Front):
    """The dialog of a topic with fields of every kind, by its keys and lines."""

    async def press(self, *keys: str) -> str:
        """Press keys, one after the other, and let the next view come."""
        await super().press(*keys)
        self.robot.show_topic()
        return await self.settle()

    async def reopen(self) -> None:
        """Open the dialog anew, as it is at first."""
        while self.app.screen is not self.main:
            await self.press("escape")
        await self.press("8", "home", "down", "enter")

    @property
    def text(self) -> str:
        return "\n".join(strip.text for strip in self.strips)


@asynccontextmanager
async def opened(size: tuple[int, int] = (120, 36)) -> AsyncIterator[Opened]:
    async with front_of(Opened, size=size) as shown:
        await shown.reopen()
        yield shown


async def test_the_keys_of_the_dialog_fold_search_plot_and_copy() -> None:
    async with opened() as shown:
        assert "base_link" in shown.text
        await shown.press("down", "down", "down", "down", "enter")
        assert "▸ header" in shown.text
        assert "base_link" not in shown.text
        await shown.press("down", "down", "enter")
        assert "[9]" in shown.text
        await shown.write(*["down"] * 21)
        assert "[19]" in shown.text
        assert "enter shows 20 more of 360" in shown.text
        await shown.press("enter")
        assert "[39]" in shown.text

        await shown.reopen()
        await shown.press("slash", *"volt", "enter")
        assert "voltage" in shown.text
        assert "percentage" not in shown.text
        assert "1 of 10" in shown.text
        await shown.press("escape")
        assert "percentage" in shown.text
        await shown.press("escape")
        assert "voltage" not in shown.text

        await shown.reopen()
        await shown.press("p", "down", "p")
        assert "60 s ago" in shown.text
        assert "voltage 24.5 V" in shown.text
        await shown.press("p", "up", "p")
        assert "60 s ago" not in shown.text
        await shown.press("down", "down", "down", "p")
        assert "battery_health is no number" in shown.text
        assert "60 s ago" not in shown.text

        await shown.reopen()
        await shown.press("y")
        wanted = "ros2 topic echo /battery_level archo_interfaces/msg/BatteryStatus"
        assert shown.app.clipboard == wanted

        await shown.reopen()
        dialog = shown.app.screen
        await shown.write("t", "enter", "p")
        await shown.press()
        await shown.until(lambda: shown.app.screen is dialog and "60 s ago" in shown.text)

        await shown.reopen()
        await shown.press("space", "p")
        assert "⣀" in shown.text or "⠉" in shown.text


async def test_a_clock_behind_a_dialog_has_only_itself_drawn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Screen, "_compositor_refresh", _DRAW)
    async with opened() as shown:
        app, drawn = shown.app, list[Region]()
        await shown.press("down")
        app.screen.refresh = lambda *regions, **_: drawn.extend(regions)  # type: ignore[method-assign,assignment]
        clock, app.main._repaint_required = app.main.query_one("#clock"), False
        for _ in range(3):
            clock.refresh()
            app.main._compositor.update_widgets({clock})
            app.main._compositor_refresh()
        assert drawn == [clock.region] * 3
        assert not app.main._repaint_required  # Else all of it is drawn with the next change.
        del app.screen.refresh


async def test_an_array_that_is_opened_frozen_shows_the_elements_of_then() -> None:
    async with console(node_makers=[STEPS], wait=False) as op:
        await open_topic(op, "/steps")
        await op.until("float32[30]")
        await op.press("end", "space")
        await op.until("frozen")
        frozen = op.line("▸ data").split("..")[1].split()[0]
        await op.at(op.app.station.clock.monotonic() + 3)
        await op.press("enter")
        await op.until("[5]")
        assert op.line("[5]").split()[2] == frozen
        await op.press("space")
        await op.until(lambda: float(op.line("[5]").split()[2]) > float(frozen) + 20)


async def test_it_fits_every_size_and_leaves_the_state_in_sight() -> None:
    async with opened() as shown:
        for width, height in ((50, 15), (200, 60)):
            while shown.app.screen is not shown.main:
                await shown.press("escape")
            reset_main(shown.main)
            await shown.resize(width, height)
            await shown.reopen()
            box = shown.app.screen.query_one(".topic").region
            assert box.y == 2
            assert box.x == (shown.main.graph.region.right if width >= 160 else 0)
            assert "percentage" in shown.text
            assert "81.55 %" in shown.text
            assert "STOP" in shown.text
            await shown.press("p")
            assert "percentage" in shown.text


async def test_a_message_is_published_from_the_topic_and_shown_in_nodes_until_ctrl_c() -> None:
    heard: list[str] = []
    words = hearing(heard, String, read=lambda message: message.data)
    async with console(node_makers=[words], wait=False) as op:
        await open_topic(op, "/words")
        await op.press("P")
        await op.until("/words  std_msgs/msg/String")
        await op.type("hello")
        await op.press("enter", "end", "backspace", "backspace", "backspace", "2", "0")
        await op.press("enter", "end", "backspace", "0", "enter")
        await op.until("This may move the robot. Publish to /words")
        assert heard == []
        await op.at(clock.seconds() + 1.0)
        await op.press("enter")
        await op.until(lambda: len(heard) > 3)
        assert set(heard) == {"hello"}
        await op.press("escape", "escape", "5")
        await op.until("▶ pub /words")
        await op.until("at 20 Hz, cancel ends it")
        await op.press("ctrl+c")
        await op.until(lambda: not op.session.robot.publications.active)
        await op.until("pub words: ended after")


VALUE, ARRAY = FieldKind.VALUE, FieldKind.ARRAY
SPEED = FieldView("twist.speed", VALUE, "float32", 0.8, unit="m/s", least=0.0, greatest=0.8)
RANGES = FieldView(
    "ranges", ARRAY, "float32[360]", unit="m", least=1.809727e-05, greatest=9.99999, nan=4
)


def line(field: FieldView, width: int) -> str:
    """The row of a field in so many cells."""
    return field_line(field, field_columns([SPEED, RANGES], width), (), ())[0]


def test_a_value_has_its_unit_or_the_name_of_its_type_for_it() -> None:
    assert value_text(SPEED) == "0.8 m/s"
    assert value_text(SPEED._replace(value=math.nan)) == "nan"
    assert value_text(FieldView("level", VALUE, "uint8", 30, constant="WARN")) == "30 WARN"
    assert value_text(FieldView("n", VALUE, "int64", 137_976)) == "137 976"
    assert value_text(FieldView("on", VALUE, "bool", True)) == "true"
    assert value_text(FieldView("text", VALUE, "string", "a\x1b[2Jb")).isprintable()
    stamp = FieldView("stamp", VALUE, "builtin_interfaces/Time", TIME + 0.12, is_time=True)
    assert value_text(stamp).endswith(":20.120")
    assert value_text(stamp._replace(value=12.5)) == "12.500 s"
    assert value_text(stamp._replace(value=1e300)).endswith(" s")


def test_a_range_is_short_and_names_what_is_nan() -> None:
    assert range_text(RANGES) == "1.81e-05 .. 10, 4 nan"
    assert range_text(SPEED._replace(least=130_002.4, greatest=137_976)) == "130 002 .. 137 976"
    assert range_text(SPEED._replace(least=None)) == ""


def test_where_there_is_no_column_an_array_has_its_range_beside_its_shape() -> None:
    assert "float32[360] 1.81e-05 .. 10, 4 nan" in line(RANGES, 50)
    assert line(RANGES, 116).split("  ")[-1].strip() == "1.81e-05 .. 10, 4 nan"


def test_a_sparkline_shows_the_spike_of_a_column_and_gaps() -> None:
    assert sparkline((None, (0.0, 0.0), (0.0, 9.0), (9.0, 9.0), (0.0, 9.0))) == " ▁██▁"
    assert sparkline(((5.0, 5.0), (5.0, 5.0))) == "▁▁"
    assert sparkline((None, None)) == ""


EXTREMES = [
    (-1.7e308, 1.7e308),
    (-sys.float_info.max, sys.float_info.max),
    (0.0, 5e-324),
    (5e-324, 5e-324),
    (1.7e308, 1.7e308),
    (0.0, 1e-310),
    (-(2**63), 2**64 - 1),
]


@pytest.mark.parametrize(("low", "high"), EXTREMES)
def test_the_greatest_and_the_least_numbers_have_curves(low: float, high: float) -> None:
    values = ((low, low), (high, high)) * 4
    bars = sparkline(values)
    assert bars == ("▁█" * 4 if high - low > 1e-300 else bars)
    assert len(bars) == len(values)
    rows = topic_plots({}, {"a": values}, ["a"], (60, 9))
    assert not any("cannot be drawn" in plain_text(row) for row in rows)
    assert {len(plain_text(row)) for row in rows[1:-1]} == {15}
    field = FieldView("a", VALUE, "float64", high, least=low, greatest=high, curve=values)
    assert bars in field_line(field, field_columns([field], 116), (), ("a",))[0]


def test_a_plot_that_cannot_be_drawn_leaves_the_others() -> None:
    broken: Any = (("no number", 1.0),)
    plots = {"a": broken, "b": ((7.0, 7.0),) * 3}
    lines = [plain_text(row) for row in topic_plots({}, plots, ["a", "b"], (60, 9))]
    assert lines[1].startswith("✗ cannot be drawn: TypeError")
    assert "b --" in lines[4]
    assert len(lines) == 9


def test_the_summary_says_what_is_out_of_the_ordinary() -> None:
    view = TopicView("/scan", "sensor_msgs/msg/LaserScan", 3, 11.3, 700.0, 0.1)
    assert plain_text(summary(view, is_frozen=False)) == "11.3 Hz   700 B/s   0.1 s old"
    assert "frozen" in plain_text(summary(view, is_frozen=True))
    assert "only the first 0 fields" in plain_text(
        summary(view._replace(is_cut=True), is_frozen=False)
    )
    quiet = TopicView("/scan", "sensor_msgs/msg/LaserScan")
    assert plain_text(summary(quiet, is_frozen=False)) == "no message yet"
    lost = quiet._replace(fault="it has no publisher: waiting for one")
    assert plain_text(summary(lost, is_frozen=False)) == lost.fault


def test_plots_share_an_axis_and_those_without_room_are_counted() -> None:
    plots = {"a": ((0.0, 1.0), None, (5.0, 5.0)), "b": ((7.0, 7.0),) * 3}
    lines = [plain_text(row) for row in topic_plots({}, plots, ["a", "b"], (60, 9))]
    assert len(lines) == 9
    assert "a --" in lines[0]
    assert "b --" in lines[4]
    assert lines[-1].endswith(" now ")
    lines = [plain_text(row) for row in topic_plots({}, plots, ["a", "b"], (60, 4))]
    assert "1 more have no room" in lines[-1]
    assert plain_text(topic_plots({}, plots, ["a"], (60, 3))[0]) == "too small for the plot"


def test_everything_has_a_form_in_ascii() -> None:
    header = FieldView("header", FieldKind.GROUP, "std_msgs/Header")
    for field, closed in ((header, ()), (header, ("header",)), (RANGES, ())):
        text, _ = field_line(field, field_columns([field], 80), closed, ("header",))
        assert "?" not in in_ascii(text)
    assert in_ascii(" ‖ 1x") == " | 1x"  # `?` says that something is not known.
    assert in_ascii("↑ ↓ Recent goals, ←→ 1 s") == "^ v Recent goals, <> 1 s"
