"""The bar of a goal's way, in three rows where there is room for them."""

from __future__ import annotations

import re

import pytest

from archo_tui.robot.state.goal import Phase
from archo_tui.text.goal import goal_strip, remaining_text
from tests.support.front import front
from tests.support.states import ARRIVED, MOVING, STATES, plain_text
from tests.support.stub import StandingClock

DRIVING = STATES["motor moving"]


def rows(goal: object, width: int = 56) -> list[str]:
    return [plain_text(line).rstrip() for line in goal_strip(goal, width, 3)]  # type: ignore[arg-type]


def test_the_way_driven_is_a_thick_bar_up_to_the_robot() -> None:
    above, line, below = rows(MOVING, 20)
    assert (above, line, below) == ("▄▄▄▄▄▄", "██████▶─────   50 %", "▀▀▀▀▀▀")
    assert rows(ARRIVED, 20)[1] == "███████████▶  100 %"


def test_no_number_moves_as_the_robot_does() -> None:
    far, near = MOVING._replace(length=100.0, remaining=100.0), MOVING._replace(length=100.0)
    first, then = rows(far, 100)[1], rows(near, 100)[1]
    assert first.index(" m ") == then.index(" m ")
    assert first.index("%") == then.index("%")


def test_a_robot_just_behind_its_goal_has_nothing_left() -> None:
    assert remaining_text(MOVING._replace(remaining=-0.04)) == "0.0 m left"


@pytest.mark.parametrize("goal", [None, MOVING._replace(phase=Phase.SENT, remaining=None)])
def test_a_way_that_is_not_known_has_no_robot_on_it(goal: object) -> None:
    assert rows(goal, 20) == ["", "────────────     --", ""]


SIZES = [((120, 36), 8), ((160, 48), 8), ((120, 29), 6), ((120, 44), 8), ((80, 36), 6)]
SIZES += [((200, 60), 8), ((79, 60), 6)]


async def test_bar_history_and_graph_take_the_room_there_is() -> None:
    async with front(DRIVING, StandingClock(), size=(120, 24)) as it:
        for (width, height), rows_of_goal in SIZES:
            await it.resize(width, height)
            assert it.main.goal.region.height == rows_of_goal, (width, height)
            shown = await it.tick()
            assert ("█▶" in shown) is (rows_of_goal == 8)
            assert len(re.findall("50 %", shown)) == 1
            assert shown.count("about 1.5 s left") == 1
            if width >= 120 and height >= 44:
                for words in ("7 History", "8 Graph", "remaining 9.0 m", "max_speed"):
                    assert words in shown, words
                assert it.main.events.region.height >= 8
        await it.resize(50, 15)
        assert it.main.goal.region.height == 6
