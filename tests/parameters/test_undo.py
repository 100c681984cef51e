"""Changes of parameters are undone one by one, the last one first, and only those that happened."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.graph import Parameter
from archo_tui.station.undo import UndoList


class Robot:
    """Has one parameter, which it may refuse to change."""

    def __init__(self) -> None:
        self.value, self.refuses = 0, False
        self.answer: asyncio.Event | None = None
        self.has_left = False

    @property
    def snapshot(self) -> Any:
        parameters = (Parameter("/n", "p", "integer", self.value, 0),)
        return SimpleNamespace(parameters=() if self.has_left else parameters)

    async def set_parameters(self, node: str, values: dict[str, Any]) -> Outcome:
        if self.answer:
            await self.answer.wait()
        if self.refuses:
            return Outcome(Code.REFUSED, "no")
        self.value = values["p"]
        return Outcome(Code.DONE, "done")


@pytest.fixture
def robot() -> Any:
    return Robot()


async def test_a_change_that_was_refused_cannot_be_undone(robot: Any) -> None:
    edits = UndoList()
    robot.refuses = True
    assert not (await edits.set_parameters(robot, "/n", {"p": 1})).ok
    assert edits.last is None
    assert (await edits.undo(robot)).text == "nothing to undo"
    robot.refuses = False
    await edits.set_parameters(robot, "/n", {"p": 1})
    robot.refuses = True
    assert not (await edits.undo(robot)).ok
    robot.refuses = False  # What cannot be undone now can be undone later.
    assert (await edits.undo(robot)).ok
    assert robot.value == 0


async def test_changes_are_under_way_until_answered_and_are_undone_one_by_one(robot: Any) -> None:
    edits, answer = UndoList(), asyncio.Event()
    robot.answer = answer
    changes = [
        asyncio.create_task(edits.set_parameters(robot, "/n", {"p": value})) for value in (1, 2)
    ]
    await asyncio.sleep(0)
    assert (edits.is_changing, edits.last) == (True, None)
    answer.set()
    await asyncio.gather(*changes)
    assert not edits.is_changing
    for value in (1, 0):
        assert (await edits.undo(robot)).ok
        assert robot.value == value


async def test_of_equal_changes_the_last_one_is_undone(robot: Any) -> None:
    edits = UndoList()
    for value in (1, 0, 1):
        await edits.set_parameters(robot, "/n", {"p": value})
    for value in (0, 1, 0):
        assert edits.changed_since(robot.snapshot) == {}
        assert (await edits.undo(robot)).ok
        assert robot.value == value
    assert edits.last is None


async def test_a_change_that_is_not_the_last_one_any_more_is_not_undone(robot: Any) -> None:
    edits = UndoList()
    await edits.set_parameters(robot, "/n", {"p": 1})
    asked = edits.last
    await edits.set_parameters(robot, "/n", {"p": 2})
    refused = await edits.undo(robot, asked)
    assert refused == (Code.REFUSED, "another change is the last one now: nothing was undone")
    assert robot.value == 2
    assert (await edits.undo(robot, edits.last)).ok
    assert robot.value == 1


async def test_what_a_node_that_left_has_no_more_is_not_set(robot: Any) -> None:
    edits = UndoList()
    robot.has_left = True
    outcome = await edits.set_parameters(robot, "/n", {"p": 1})
    assert outcome == (Code.NOT_OFFERED, "/n does not report p any more")
    assert (robot.value, edits.last) == (0, None)
