"""A restart of the console: it waits while a STOP is not released, and takes along what waits."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from archo_tui.base import handover
from archo_tui.base.handover import Handover
from archo_tui.robot.clients import Requester
from archo_tui.robot.state.snapshot import Latch, OpenStop, Snapshot
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from archo_tui.station.shutdown import RESTART
from tests.support import chosen, clock
from tests.support.console import AT_ONCE, FAST, console
from tests.support.front import Front, front_of
from tests.support.quiet import until
from tests.support.states import MOTOR, NORMAL

HELD = NORMAL._replace(latch=Latch.HELD, motion=replace(MOTOR, stopped=True))
UNCERTAIN = NORMAL._replace(latch=Latch.UNCERTAIN)
OPEN = NORMAL._replace(open_stop=OpenStop(0.0))


class Saved(Front):
    """In front of a console with a file that is saved; the codes with which it begins to end."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.codes, self.events = list[int](), list[str]()
        self.app.exit = lambda *_, return_code=0, **__: self.codes.append(return_code)  # type: ignore[method-assign]
        self.robot.note = lambda _, __, text, **___: self.events.append(text)

    async def save(self) -> None:
        self.app.station.restart("interfaces were saved")
        await self.settle()


@pytest.mark.parametrize("stopped", [HELD, UNCERTAIN, OPEN], ids=["held", "uncertain", "open"])
async def test_a_restart_waits_for_the_release_and_then_for_a_key(stopped: Snapshot) -> None:
    async with front_of(Saved) as it:
        it.robot.put(stopped)
        await it.save()
        assert it.codes == []
        waits = "the restart waits: release the STOP, then press ^r in Nodes"
        assert it.events == [f"interfaces were saved: {waits}"]
        assert "5 Nodes   restart waits" in await it.press("5")
        assert "release" in await it.press("ctrl+r")  # Why not now.
        assert it.codes == []
        await it.put(NORMAL)
        assert it.codes == []  # The release itself begins nothing.
        await it.press("ctrl+r")
        assert it.codes == [RESTART]
        assert it.events[-1] == "interfaces were saved: all nodes restart"


async def test_a_stop_that_was_read_and_has_no_answer_keeps_the_console_too() -> None:
    async with front_of(Saved) as it:
        it.robot.stops.register()
        await it.save()
        assert it.codes == []
        assert "the restart waits" in it.events[-1]


async def test_a_stop_while_the_console_begins_to_end_calls_the_restart_off() -> None:
    async with front_of(Saved) as it:
        allowed: list[bool] = []

        async def stop_sending_goals() -> None:
            it.robot.snapshot = HELD  # Read, sent and confirmed in this moment.

        it.robot.stop_sending_goals = stop_sending_goals
        it.robot.allow_sending_goals = lambda: allowed.append(True)
        await it.save()
        assert it.codes == []
        assert allowed == [True]
        assert "the restart waits" in it.events[-1]
        await it.put(NORMAL)
        await it.press("5", "ctrl+r")  # And begins again, though it was begun before.
        assert it.codes == []  # Another STOP came.


async def test_without_a_stop_a_saved_file_restarts_at_once() -> None:
    async with front_of(Saved) as it:
        assert "restart" not in await it.press("5")
        await it.press("ctrl+r")
        assert it.codes == []  # Nothing waits.
        await it.save()
        assert it.codes == [RESTART]
        assert "? the console restarts" in it.text  # Not `online`.


GOALS = tuple(
    (
        "go",
        "Go to shelf",
        "move_to_shelf",
        "archo_interfaces/action/MoveToShelf",
        {"shelf_number": n},
    )
    for n in (4, 5)
)
EDITS = (("/motor_controller", {"max_speed": 0.8}, {"max_speed": 0.3}),)
LEFT = Handover("interfaces were saved", goals=GOALS, edits=EDITS)


async def test_the_queue_is_held_and_values_set_by_hand_are_set_again() -> None:
    async with console(*FAST, handover=LEFT) as op:
        assert "held: 4, 5 (restart)" in op.text
        assert "interfaces were saved: restarted" in op.text
        assert "0.3" in op.line("max_speed")
        await op.press("4", "u")  # And can be undone.
        await op.until(lambda: "0.8" in op.line("max_speed"))
        await op.press("n")
        await op.until(lambda: "Arrived at shelf 5" in op.text)


async def test_a_stop_of_the_gap_is_carried_out_before_a_node_spins() -> None:
    left = LEFT._replace(stop=True)
    options = Options(
        engine=chosen.ENGINE, domain_id=chosen.next_domain(), ros_args=AT_ONCE, handover=left
    )
    with Session(options, clock.current) as session:
        robot = session.robot
        await until(lambda: robot.snapshot.motion.received is not None)
        assert robot.snapshot.motion.stopped  # Nothing was sent yet: nobody is there to send it.
        assert session.station.restart_blocker
    async with console(*FAST, handover=left) as op:
        await op.until(lambda: "STOP: confirmed" in op.text)
        assert "held: 4, 5 (STOP)" in op.text
        assert "STOP was read while the console restarted: sent now" in op.text


def test_what_is_left_is_read_once_and_by_nobody_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ARCHO_TUI_HANDOVER", raising=False)
    assert handover.take() is None
    handover.give(LEFT)
    path = Path(os.environ["ARCHO_TUI_HANDOVER"])
    assert path.stat().st_mode & 0o077 == 0
    left = handover.take()
    assert left is not None
    assert json.dumps(left) == json.dumps(LEFT)  # Tuples are lists by now.
    assert not path.exists()
    assert handover.take() is None


async def test_a_waiting_clients_goal_is_not_taken_along_and_a_late_stop_is() -> None:
    async with console(*FAST, handover=LEFT) as op:
        waiting = Requester("SHELL", "pid 7")
        waiting.waits = True
        goals = op.session.station.goals
        first, *rest = goals.queue.waiting
        waits = first._replace(requester=waiting)
        goals.queue = goals.queue._replace(waiting=(waits, *rest))
        left = op.session.hand_over()
        assert [values for *_, values in left.goals] == [{"shelf_number": 5}]
        assert [*left.edits] == [*EDITS]
        assert not left.stop
        stops = op.session.robot.stops
        stops.answered = stops.register()  # What sent it was cancelled.
        assert op.session.hand_over().stop
