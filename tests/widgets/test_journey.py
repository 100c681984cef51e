"""A goal's journey in three rows, where there is room for them."""

from __future__ import annotations

import re

import pytest

from archo_tui.robot.state.goal import Phase
from archo_tui.widgets.journey import bar, ends, pace
from archo_tui.words.state import plain_text
from tests.support.clock import NOW
from tests.support.console import screen_text
from tests.support.quiet import Quiet
from tests.support.states import ARRIVED, MOVING, STATES
from tests.support.stub import StandingClock, stub_app

DRIVING = STATES["motor moving"]


def test_the_rows_say_where_it_is_how_fast_and_what_follows() -> None:
    assert plain_text(ends(MOVING, 50)) == "START                9.0 m left    50 %   shelf 12"
    assert plain_text(bar(MOVING, 10)) == "█████▶░░░░"
    said = "0.80 m/s    about 1.5 s left             then 7, 3"
    assert plain_text(pace(DRIVING, NOW, 50, ("7", "3"))) == said


def test_no_number_moves_as_the_robot_does() -> None:
    far, near = MOVING._replace(length=100.0, remaining=100.0), MOVING._replace(length=100.0)
    first, then = plain_text(ends(far, 50)), plain_text(ends(near, 50))
    assert first.index(" left") == then.index(" left")
    assert first.index("%") == then.index("%")
    assert plain_text(bar(far, 10)) == "▶░░░░░░░░░"
    assert plain_text(bar(ARRIVED, 10)) == "█████████▶"


@pytest.mark.parametrize("goal", [None, MOVING._replace(phase=Phase.SENT, remaining=None)])
def test_a_way_that_is_not_known_has_no_robot_on_it(goal: object) -> None:
    assert plain_text(bar(goal, 10)) == "░" * 10  # type: ignore[arg-type]
    assert plain_text(ends(goal, 30)).endswith("-- left    -- %")  # type: ignore[arg-type]


def test_a_long_target_is_cut_and_no_number_is() -> None:
    far = MOVING._replace(fields={"shelf_number": 123456789012345})
    assert plain_text(ends(far, 40)) == "START  9.0 m left    50 %   shel…9012345"


def test_a_queue_without_room_is_cut_at_its_end() -> None:
    said = plain_text(pace(DRIVING, NOW, 50, tuple("123456789")))
    assert said == "0.80 m/s    about 1.5 s left    then 1, 2, 3, 4, …"


@pytest.mark.parametrize(
    ("size", "is_large"),
    [((120, 36), True), ((80, 34), True), ((160, 48), True), ((120, 33), False), ((79, 60), False)],
)
async def test_the_journey_is_large_where_there_is_room(
    size: tuple[int, int], is_large: bool
) -> None:
    app = stub_app(DRIVING, StandingClock(), size=size)
    async with app.run_test(size=size):
        await Quiet(app).settle()
        assert app.main.goal.region.height == (8 if is_large else 6)
        assert ("START" in screen_text(app)) is is_large
        assert len(re.findall("50 %", screen_text(app))) == 1
        assert screen_text(app).count("about 1.5 s left") == 1


async def test_the_journey_follows_the_size_of_the_terminal() -> None:
    app = stub_app(DRIVING, StandingClock(), size=(120, 36))
    async with app.run_test(size=(120, 36)) as pilot:
        for size, height in (((120, 24), 6), ((160, 48), 8), ((50, 15), 6), ((80, 36), 8)):
            await pilot.resize_terminal(*size)
            await Quiet(app).settle()
            assert app.main.goal.region.height == height, size
