"""Several targets, driven one after the other, held by what is no arrival; the bar of the way."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from archo_tui.robot.state.goal import Phase
from archo_tui.text.goal import goal_strip
from tests.support.clock import seconds
from tests.support.console import BRISK, FAST, LONG, Console, console
from tests.support.front import front
from tests.support.states import ARRIVED, MOVING, STATES, plain_text
from tests.support.stub import StandingClock


def history(op: Console) -> list[str]:
    """The targets that were driven, the oldest first."""
    return [f"{goal.target} {goal.word}" for goal in reversed(op.app.view.snapshot.history)]


async def test_several_targets_are_driven_in_turn_and_a_mistake_stays_said() -> None:
    async with console(*BRISK) as op:
        await op.press("g", *"12 7 3", "enter")
        await op.until("MOVING to 12")
        assert "then 7, 3" in op.text
        await op.until("MOVING to 7")
        assert "then 3" in op.text
        await op.until(lambda: len(op.app.view.snapshot.history) == 3)
        assert history(op) == ["12 ARRIVED", "7 ARRIVED", "3 ARRIVED"]
        assert not op.app.view.waiting

        await op.press("escape", "escape")
        await op.press("g", *"12 7", "enter")
        await op.until("MOVING to 12")
        await op.press("x", "enter")
        await op.until("Shelf: not a whole number: x")
        await op.until("MOVING to 7")
        await op.settle()
        assert "Shelf: not a whole number: x" in op.text


async def test_a_double_enter_sends_once_a_form_waits_and_a_cancel_holds_the_rest() -> None:
    async with console(*LONG) as op:
        await op.press("g", "5", "enter", "enter")
        await op.until("MOVING to 5")
        await op.press("6", "enter", "enter", "enter")
        await op.until("then 6")
        await op.settle()
        assert op.app.view.waiting == ("6",)

        await op.press("escape", "G", *"shelf", "enter")
        await op.until("Shelf ")  # the form of the robot file
        await op.press("7", "enter")
        await op.settle()  # not with the next second only
        assert "then 6, 7" in op.text

        await op.press("ctrl+c")
        await op.until("held: 6, 7 (cancelled)   n continue   k skip")
        await op.settle()
        assert history(op) == ["5 CANCELLED"]


async def test_a_refused_target_holds_the_rest_until_it_is_continued(unlimited: Path) -> None:
    async with console(*FAST, robot=unlimited) as op:
        await op.press("g", *"12 99 7 3", "enter")
        await op.until("held: 7, 3 (refused)")
        assert re.search(r"✗ REFUSED      at \d\d:\d\d:\d\d: shelf 99 is not in 1 .. 40", op.text)
        assert history(op) == ["12 ARRIVED", "99 REFUSED"]
        await op.until("queue held: 7, 3 (refused)")
        await op.at(seconds() + 3.0)
        (noted,) = (e for e in op.app.view.snapshot.events if e.text.startswith("queue held"))
        assert noted.count == 1
        await op.press("escape", "k")
        await op.until("held: 3 (refused)")
        await op.press("n")
        await op.until("MOVING to 3")
        await op.until(lambda: history(op)[-1] == "3 ARRIVED")
        await op.until(lambda: "✗ 99 refused" in op.line("last goals:"))


async def test_nothing_is_sent_behind_a_stop_and_its_release_continues_nothing() -> None:
    async with console(*LONG) as op:
        op.send("g", *"12", "enter", *"7")  # what is typed behind enter is the next target
        await op.until("m left of")
        assert op.app.main.goal.fields[0].value == "7"
        await op.press("enter")
        await op.until("then 7")
        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        await op.until("held: 7 (STOP)")
        await op.press("escape", "n")
        await op.until("continue the queue: still held: STOP")
        assert op.app.view.waiting == ("7",)
        await op.press("R", "y")
        await op.until("● IDLE")
        await op.settle()
        assert history(op) == ["12 ABORTED"]
        assert op.app.view.waiting == ("7",)
        await op.press("n")
        await op.until("MOVING to 7")


async def test_a_wrong_target_sends_none_and_the_arrows_recall_what_was_sent() -> None:
    async with console(*FAST) as op:
        await op.press("n")
        await op.until("no queue is held")
        await op.press("k")
        await op.until("no goal waits in the queue")

        await op.press("ctrl+u", "escape")
        await op.press("g", *"12 99999999999 3", "enter")
        await op.until("Shelf: at most")
        await op.settle()
        assert op.app.view.snapshot.goal is None
        assert not op.app.view.waiting

        await op.press("ctrl+u")
        for text in ("12", "7 3"):
            await op.press("g", *text, "enter")
            await op.until(lambda: not op.app.view.waiting)
        await op.type("4")
        field = op.app.main.goal.fields[0]
        seen = []
        for key in ("up", "up", "up", "down", "down"):
            await op.press(key)
            seen.append(field.value)
        assert seen == ["7 3", "12", "12", "7 3", "4"]


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


@pytest.mark.parametrize("goal", [None, MOVING._replace(phase=Phase.SENT, remaining=None)])
def test_a_way_that_is_not_known_has_no_robot_on_it(goal: object) -> None:
    assert rows(goal, 20) == ["", "────────────     --", ""]


SIZES = [((120, 29), 6), ((120, 44), 8), ((80, 36), 6), ((200, 60), 8), ((79, 60), 6)]


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
