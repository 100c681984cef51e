"""STOP, a goal and the queue of goals, explored to the last state of small worlds."""

from __future__ import annotations

import contextlib
from typing import Any

import pytest

from archo_tui.robot.goals import queue
from archo_tui.robot.goals.machine import PHASES, Event, TrackedGoal
from archo_tui.robot.state.goal import RUNNING, Phase
from archo_tui.robot.stop import machine
from tests.robot import explore, explore_goal, explore_queue
from tests.robot.exploring import planted
from tests.support.night import corners

pytestmark = pytest.mark.pure


SMALL: list[Any] = [(room, name) for room in (explore, explore_queue) for name in room.SMALL]
LARGE: list[Any] = [
    *((explore_queue, name) for name in explore_queue.LARGE),
    (explore_goal, "2.6 or 16 s"),
]


@pytest.mark.parametrize(("exploring", "name"), corners(SMALL, LARGE))
def test_every_promise_holds_in_every_state(exploring: Any, name: str) -> None:
    found = exploring.explore(exploring.begin(**exploring.WORLDS[name]))
    assert found.broken == "", found.way


def test_every_promise_holds_in_every_state_of_a_goal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fire, cells = TrackedGoal.fire, set[Any]()

    def fire_and_note(goal: Any, event: Any, *rest: Any, **more: Any) -> Any:
        cells.add((event, goal.goal.phase))
        return fire(goal, event, *rest, **more)

    monkeypatch.setattr(TrackedGoal, "fire", fire_and_note)
    found = explore_goal.explore(explore_goal.begin())
    assert (found.broken, found.states > 1000) == ("", True), found
    every = {(event, phase) for event in PHASES for phase in RUNNING}
    assert every - cells == {(Event.CANCEL_FAILED, Phase.SENT)}  # No cancel leaves before it.


@pytest.mark.night
def test_every_event_is_met_in_every_state_of_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    fire, cells = machine.Stop._fire, set[Any]()

    def fire_and_note(stop: Any, event: Any, doubt: str = "") -> Any:
        cells.add((event, stop.state))
        return fire(stop, event, doubt)

    monkeypatch.setattr(machine.Stop, "_fire", fire_and_note)
    for world in explore.WORLDS.values():
        found = explore.explore(explore.begin(**world))
        assert found.broken == "", found.way
    for event, states in machine.LATCH.items():
        for before, to in zip(machine.State, states, strict=True):
            assert to is None or (event, before) in cells


@pytest.mark.night
@pytest.mark.parametrize(
    ("faultless", "exploring"), [(machine, explore), (queue, explore_queue)], ids=["STOP", "queue"]
)
def test_of_faults_planted_at_random_the_small_worlds_find_many(
    faultless: Any, exploring: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def is_found(faulty: Any) -> bool:
        monkeypatch.setattr(exploring, "machine", faulty)
        with contextlib.suppress(Exception):  # Whatever it raises is found, too.
            worlds = [exploring.begin(**world) for world in exploring.SMALL.values()]
            return any(exploring.explore(world).broken for world in worlds)
        return True

    found = {what: is_found(faulty) for what, faulty in planted(faultless, 60)}
    # What is left are words, and times to the tick: the tests of the rules have them.
    assert sum(found.values()) > 60 // 3, [what for what, is_found in found.items() if not is_found]
