"""Several targets: driven one after the other, held by whatever is not an arrival."""

from __future__ import annotations

from pathlib import Path

from tests.support.clock import seconds
from tests.support.console import BRISK, FAST, LONG, Console, console


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
