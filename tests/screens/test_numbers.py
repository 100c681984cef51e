"""Numbers are whole at every width, or said to be cut; rates are those of now."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

import pytest

from archo_tui.robot.state.graph import NodeState, Parameter
from archo_tui.robot.state.snapshot import Latch, OpenStop, Snapshot
from archo_tui.screen.main import PANELS
from archo_tui.screen.widgets.line import aligned
from archo_tui.text import line_by_line
from archo_tui.text.goal import goal_line
from archo_tui.text.plot import time_left_text
from archo_tui.text.state import PLAIN, charge_bar, marked_tone, motion_age, motion_line
from archo_tui.verbs.as_json import state
from tests.support.clock import NOW, TIME
from tests.support.console import console
from tests.support.front import front
from tests.support.night import corners
from tests.support.states import MOTOR, MOVING, NORMAL, plain_text
from tests.support.stub import StandingClock, StubRobot, stub_station

# each number begins with a nine: a part of one is then no other number of the screen
WHOLE = NORMAL._replace(
    battery=NORMAL.battery._replace(percentage=98.7, voltage=96.5),
    charge=tuple((NOW - 60 + second, 98.7) for second in range(61)),
    motion=NORMAL.motion.__class__(9_876_543, 9.87, True, False, NOW - 0.1),
    goal=MOVING._replace(
        fields={"shelf_number": 9753},
        length=987.6,
        remaining=97.5,
        sent=NOW - 95.1,
        started=NOW - 94.2,
        way=(),
    ),
    nodes=tuple(NodeState(f"/node_with_a_long_name_{name}", NOW - 0.9, 97.3) for name in "abc"),
    events=tuple(
        event.__class__(
            TIME - 40, "WARN", "motor_controller", "max_speed 9765 refused: allowed 90.05"
        )
        for event in NORMAL.events
    ),
    resources=(),
)


def parameters(count: int) -> tuple[Parameter, ...]:
    """Some with long values and ranges."""
    return tuple(
        Parameter(
            f"/node_{'x' * n}", f"gain_{'y' * n}", "double", 987654.25, 9.5, "", 91.125, 98765.5
        )
        for n in range(count)
    )


def numbers(snapshot: Snapshot) -> set[str]:
    """Every number that the screen may show."""
    known = "98.7 96.5 9.87 9753 987.6 97.5 890.1 90 95.1 94.2 10.3 0.9 97.3 9765 90.05"
    ranges = "987654.25 91.125 98765.5 9.5"
    fixed = "20 1 10 0 100 99 1000 0.5 5"  # scales, the low mark
    panels = (str(panel.number) for panel in PANELS)
    return {*known.split(), *ranges.split(), *fixed.split(), *panels, "9 876 543"}


def tokens(line: str) -> Iterator[str]:
    """The numbers of a line that are not said to be cut; times of day are left out."""
    line = re.sub(r"\d\d:\d\d(:\d\d)?", "", line)
    for found in re.finditer(r"\d{1,3}(?: \d{3})+|\d+(?:\.\d+)?\.?", line):
        if line[found.end() : found.end() + 1] != "…":
            yield found[0]


@pytest.mark.parametrize("count", corners([60], [3]))
async def test_no_number_is_cut_without_saying_so_at_any_width(
    count: int, request: pytest.FixtureRequest
) -> None:
    step = 1 if request.config.getoption("--night") else 52
    snapshot = WHOLE._replace(parameters=parameters(count))
    async with front(snapshot, StandingClock(), size=(300, 40)) as it:
        seen: set[str] = set()
        for width in range(300, 39, -step):
            await it.resize(width, 40)
            for strip in it.strips:
                for part in re.split(r"[│┃╭╮╰╯┏┓┗┛]", strip.text):
                    found = set(tokens(part))
                    seen |= found
                    assert found <= numbers(snapshot), (width, part)
        assert {"98.7", "96.5", "9 876 543", "987654.25", "97.3"} <= seen


def test_numbers_end_at_the_right_with_the_word_at_the_left() -> None:
    line = (("▲ LOW", PLAIN), (" 18.0 %", PLAIN), (" 21.3 V", PLAIN))
    assert plain_text(aligned(line, 30)) == "▲ LOW           18.0 %  21.3 V"
    assert plain_text(aligned(line, 21)) == "▲ LOW  18.0 %  21.3 V"
    assert plain_text(aligned(line, 20)) == "▲ LOW  18.0 % 21.3 V"  # where it is tight
    assert (
        plain_text(aligned(line, 5)) == "▲ LOW 18.0 % 21.3 V"
    )  # what is too long is cut by its line


@pytest.mark.parametrize("percentage", [10.0, 20.0, 50.0, None])
def test_the_low_mark_is_drawn_on_the_bar(percentage: float | None) -> None:
    bar = charge_bar(percentage, 20.0, 40, "active")
    assert len(plain_text(bar)) == 40
    ((_, tone),) = [(text, tone) for text, tone in bar if "╎" in text]
    assert tone == marked_tone("active" if (percentage or 0) > 20 else "edge")


async def test_readings_of_a_slow_robot_have_their_age_before_they_are_old() -> None:
    slow = NORMAL._replace(
        battery=NORMAL.battery._replace(received=NOW - 6.7, period=6.0),
        motion=replace(NORMAL.motion, received=NOW - 4.2, period=6.0),
    )
    assert line_by_line.battery_text(slow, NOW).endswith("24.1 V, 7 s ago")
    assert line_by_line.motion_text(slow, NOW).endswith("0.00 m/s, 4 s ago")
    async with front(slow, StandingClock(), size=(80, 24)) as it:
        assert re.search(r"● GOOD +87.5 % +7 s ago", it.text)
        assert "● IDLE  4 s ago" in it.text
        stopped = replace(slow.motion, stopped=True, received=NOW - 13, period=20.0)
        it.robot.put(slow._replace(motion=stopped))
        await it.settle()
        assert "│✗ STOPPED  13 s ago" in it.text
        assert "press R to release" in it.text
    assert motion_age(slow, NOW)
    for doubt in ({"open_stop": OpenStop(NOW - 0.5)}, {"latch": Latch.UNCERTAIN}):
        assert not motion_age(slow._replace(**doubt), NOW)  # Its words are no report.
    station = stub_station(StubRobot(slow), StandingClock())
    station.on_snapshot(slow)
    assert state(station)["motion"]["word"] == "IDLE"  # Which programs compare.


def simulated(value: object) -> Snapshot:
    scale = Parameter("/motor_controller", "time_scale", "double", value, value)
    return NORMAL._replace(goal=MOVING, motion=MOTOR, parameters=(*NORMAL.parameters, scale))


def test_the_factor_stands_beside_the_speed_and_the_time_left() -> None:
    snapshot = simulated(7.5)
    assert plain_text(motion_line(snapshot, NOW)).endswith("0.00 m/s x 7.5")
    assert plain_text(goal_line(snapshot, NOW, "")).endswith("about 1.5 s left x 7.5")
    assert line_by_line.motion_text(snapshot, NOW).endswith("0.00 m/s x 7.5")
    assert line_by_line.goal_text(snapshot, NOW, "").endswith("about 1.5 s left x 7.5")


@pytest.mark.parametrize(
    ("count", "said"),  # in the 24 cells of a terminal of 80 columns
    [
        (15_420, "15 420 0.00 m/s x 7.5"),
        (12_345_678, "12345678 0.00 m/s x 7.5"),
        (1_234_567_890, "0.00 m/s x 7.5"),
    ],
)
def test_where_room_is_short_the_factor_stays_and_the_count_gives_way(
    count: int, said: str
) -> None:
    snapshot = simulated(7.5)._replace(motion=replace(MOTOR, count=count))
    assert plain_text(motion_line(snapshot, NOW, 24)).strip() == said


@pytest.mark.parametrize("value", [1.0, "fast", float("nan"), -2.0])
def test_nothing_is_said_of_real_time_nor_of_what_is_no_factor(value: object) -> None:
    assert simulated(value).time_factor is None
    assert plain_text(motion_line(simulated(value), NOW)).endswith("0.00 m/s")
    assert plain_text(goal_line(simulated(value), NOW, "")).endswith("about 1.5 s left")


def test_the_factor_is_whole_or_not_beside_the_time_left() -> None:
    whole = plain_text(goal_line(simulated(7.5), NOW, ""))
    for width in range(40, 90):
        said = plain_text(goal_line(simulated(7.5), NOW, "", width))
        assert said.endswith((" x 7.5", " left"))
        assert len(said) <= max(width, len(whole.removesuffix(" x 7.5")))


async def test_archo_says_that_it_drives_faster_until_it_does_not() -> None:
    async with console("-p", "route_length:=100.0") as op:
        await op.press("g", "5", "enter")
        await op.until("0.80 m/s x 7.5")
        await op.until(lambda: re.search(r"about \d+.\d s left x 7.5", op.text))
        await op.press("h")
        await op.until("speed 0.80 m/s x 7.5")
        await op.press("escape")
        await op.app.station.robot.set_parameters("/motor_controller", {"time_scale": 1.0})
        await op.until(lambda: "x 7.5" not in op.text)


Rates = list[tuple[float, float]]  # Pairs of % in a second, and seconds.


def samples(start: float, rates: Rates) -> tuple[tuple[float, float], ...]:
    """Return the charge of each second."""
    found = [(100.0, start)]
    for rate, seconds in rates:
        for _ in range(round(seconds)):
            at, charge = found[-1]
            found.append((at + 1.0, charge + rate))
    return tuple(found)


@pytest.mark.parametrize(
    ("start", "rates", "said"),
    [
        (22.5, [(-2.0, 10)], "empty in about 1 s"),
        (30.0, [(-2.0, 12)], "empty in about 3 s"),
        (60.0, [(-0.5, 40)], "empty in about 80 s"),
        (52.5, [(0.0, 25), (-2.0, 5)], "empty in about 20 s"),
        (60.0, [(-2.0, 20), (-0.05, 10)], ""),
        (60.0, [(-0.01, 30)], "empty in about 2 h"),
        (60.0, [(0.0, 30)], ""),
    ],
)
def test_the_time_left_goes_by_the_present_rate(start: float, rates: Rates, said: str) -> None:
    assert time_left_text(samples(start, rates), charging=False) == said


def test_the_time_to_a_full_battery_goes_by_the_present_rate_too() -> None:
    rates = [(0.5, 25.0), (2.0, 5.0)]
    assert time_left_text(samples(60.0, rates), charging=True) == "full in about 9 s"
