"""The history: samples in, columns and curves out."""

from __future__ import annotations

from dataclasses import replace

from archo_tui.station.history import History
from archo_tui.widgets.plot import curve
from tests.support.console import screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import BATTERY, MOTOR, MOVING, NORMAL
from tests.support.stub import StubRobot, stub_app


def filled(seconds: int) -> History:
    """The charge is the second's number."""
    history = History()
    for second in range(seconds):
        battery = BATTERY._replace(percentage=float(second), received=float(second))
        history.add(NORMAL._replace(battery=battery), float(second))
    return history


def test_each_column_has_the_last_value_of_its_part() -> None:
    found = filled(100).columns("charge", 50.0, 5, 99.0)
    assert found == [59.0, 69.0, 79.0, 89.0, 99.0]


def test_a_column_that_is_past_never_changes() -> None:
    history = filled(100)
    before = history.columns("charge", 50.0, 5, 95.0)
    history.add(NORMAL._replace(battery=BATTERY._replace(percentage=7.0, received=101.0)), 101.0)
    after = history.columns("charge", 50.0, 5, 101.0)
    assert after == [*before[1:4], 99.0, 7.0]


def test_parts_shorter_than_a_second_have_no_gaps() -> None:
    found = filled(20).columns("charge", 10.0, 40, 19.0)
    assert None not in found[-36:]


def test_what_is_old_or_not_reported_is_a_gap() -> None:
    history = History()
    for second in range(10):
        battery = BATTERY._replace(received=0.0)  # silent from the first second on
        motion = replace(MOTOR, speed=None, received=float(second))
        history.add(NORMAL._replace(battery=battery, motion=motion), float(second))
    assert history.columns("charge", 10.0, 10, 9.0)[-5:] == [None] * 5
    assert history.columns("speed", 10.0, 10, 9.0) == [None] * 10


def test_the_way_left_is_only_of_a_goal_that_runs() -> None:
    history = History()
    history.add(NORMAL._replace(goal=MOVING), 1.0)
    history.add(NORMAL._replace(goal=None), 2.0)
    assert history.columns("left", 2.0, 2, 2.0) == [9.0, None]


async def test_a_way_that_becomes_known_is_shown_at_once_and_while_it_is() -> None:
    app = stub_app(NORMAL._replace(goal=MOVING._replace(remaining=None)))
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        send(app, "h")
        await quiet.settle()
        assert "left -- m" in screen_text(app)
        robot.put(NORMAL._replace(goal=MOVING))
        await quiet.settle()
        assert "left 9.0 m" in screen_text(app)
        robot.put(NORMAL)
        await quiet.settle()
        assert "left -- m" in screen_text(app)


def test_it_is_bounded_to_an_hour() -> None:
    history = filled(5000)
    assert history.columns("charge", 5000.0, 5000, 4999.0).count(None) == 1400


def test_a_curve_joins_its_dots_and_dashes_the_row_of_a_mark() -> None:
    assert curve([0, 0, 3, 3], 0, 3, 1) == ["⣀⡏"]
    assert curve([None, 0.0], 0, 10, 2) == [" ", "⢀"]
    assert curve([8.0, 8.0, None, None], 0, 8, 2, mark=1.0) == ["⠉ ", "┄┄"]
