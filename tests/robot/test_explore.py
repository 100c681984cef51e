"""STOP and the queue of goals, explored to the last state of small worlds."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

import pytest

from archo_tui.robot.goals import queue
from archo_tui.robot.stop import machine
from tests.robot import explore, explore_queue
from tests.robot.exploring import Found, planted

pytestmark = pytest.mark.pure

Worlds = dict[str, Callable[..., Any]]


@pytest.mark.parametrize("name", explore.SMALL)
def test_every_promise_holds_in_every_state(name: str) -> None:
    found, _ = explore.explore(explore.SMALL[name]())
    assert found.broken == "", found.way


@pytest.mark.parametrize(
    "name",
    [
        *explore_queue.SMALL,
        *(pytest.param(name, marks=pytest.mark.night) for name in explore_queue.LARGE),
    ],
)
def test_every_promise_of_the_queue_holds_in_every_state(name: str) -> None:
    found = explore_queue.explore(explore_queue.WORLDS[name]())
    assert found.broken == "", found.way


@pytest.mark.night
def test_every_promise_holds_in_every_state_of_larger_worlds_too() -> None:
    cells: set[tuple[str, str]] = set()
    for make in explore.WORLDS.values():
        found, visited = explore.explore(make())
        assert found.broken == "", found.way
        cells |= visited
    assert explore.unvisited(cells) == []


@pytest.mark.night
@pytest.mark.parametrize(
    ("machine", "worlds", "explored"),
    [
        (machine, explore.SMALL, lambda world: explore.explore(world)[0]),
        (queue, explore_queue.SMALL, explore_queue.explore),
    ],
    ids=["STOP", "queue"],
)
def test_of_faults_planted_at_random_the_small_worlds_find_many(
    machine: ModuleType, worlds: Worlds, explored: Callable[[Any], Found]
) -> None:
    def is_found(module: ModuleType, makes: Iterable[Callable[..., Any]]) -> bool:
        with contextlib.suppress(Exception):  # Whatever it raises is found, too.
            return any(explored(make(module=module)).broken for make in makes)
        return True

    found = {what: is_found(faulty, worlds.values()) for what, faulty in planted(machine, 60)}
    # What is left are words, and times to the tick: the tests of the rules have them.
    assert sum(found.values()) > 60 // 3, [what for what, is_found in found.items() if not is_found]
