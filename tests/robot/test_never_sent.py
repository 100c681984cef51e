"""A goal that never left is refused with the reason, and stands in nobody's way."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.goal import Phase
from tests.support.archo import SHELF, go
from tests.support.quiet import ended, until
from tests.support.robot import robot


class Shelves(Node):
    """Serves the action; its goals succeed at once."""

    def __init__(self, made: list[Shelves], **options: Any) -> None:
        super().__init__("shelves", **options)
        self.heard: list[int] = []
        self.server = ActionServer(self, MoveToShelf, "move_to_shelf", self.execute)
        made.append(self)

    def execute(self, goal: Any) -> MoveToShelf.Result:
        self.heard.append(goal.request.shelf_number)
        goal.succeed()
        return MoveToShelf.Result(success=True)


@pytest.mark.parametrize("error", [TypeError("no bytes of it"), RuntimeError("rcl: out of memory")])
async def test_a_goal_whose_sending_raises_is_refused_and_the_next_one_goes(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Shelves] = []
    async with robot(lambda **options: Shelves(made, **options), offers="move_to_shelf") as it:
        with monkeypatch.context() as patched:

            def raises(*_: Any, **__: Any) -> None:
                raise error

            patched.setattr(ActionClient, "send_goal_async", raises)
            outcome = await ended(go(it, 7))
        reason = f"not sent: {type(error).__name__}: {error}"
        assert outcome == (Code.REFUSED, reason)
        await until(lambda: it.snapshot.goal is not None)
        goal = it.snapshot.goal
        assert goal is not None
        assert (goal.phase, goal.message) == (Phase.REFUSED, reason)
        assert it.snapshot.running == 0
        assert (await ended(go(it, 8))).text == "accepted"
        await until(lambda: made[0].heard == [8])
        await until(lambda: [one.phase for one in it.snapshot.history][-1:] == [Phase.REFUSED])


async def test_a_goal_whose_value_does_not_fit_never_becomes_one() -> None:
    made: list[Shelves] = []
    async with robot(lambda **options: Shelves(made, **options), offers="move_to_shelf") as it:
        outcome = await ended(it.send(SHELF, {"shelf_number": 1.5}))
        assert outcome == (Code.MISUSE, "shelf_number: 1.5 is not a whole number")
        assert it.snapshot.goal is None
        assert (await ended(go(it, 8))).ok
        assert made[0].heard[:1] in ([], [8])
