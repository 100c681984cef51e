"""The robot is waited for at the start only; what is missing later is said at once."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.robot.state.snapshot import Hosted, Life
from tests.support.clock import seconds
from tests.support.console import LONG
from tests.support.hesitant import Hesitant
from tests.support.plain import operated
from tests.support.quiet import until
from tests.support.robot import making


def alone(**options: Any) -> Node:
    """It offers nothing."""
    return Node("alone", **options)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("reset", "failed: reset: reset_encoder is not offered by any node"),
        *(
            pytest.param(*line_and_said, marks=pytest.mark.waits)
            for line_and_said in (
                ("go 12", "failed: go: move_to_shelf is not offered by any node"),
                (
                    "release --yes",
                    "failed: release: release_emergency_stop is not offered by any node",
                ),
                ("call blink", "failed: call: no service is on the graph"),
                ("send_goal reach", "failed: send_goal: no action is on the graph"),
                ("cancel", "failed: cancel: no goal is running"),
                ("continue", "failed: continue: no queue is held"),
            )
        ),
    ],
)
async def test_what_is_missing_is_said_at_once_and_keeps_no_line_behind_it(
    line: str, said: str
) -> None:
    async with operated(alone) as person:
        began = seconds()
        await person.enter(f"{line}", said)
        assert seconds() - began <= 5.1  # at the start it may only not be found yet
        await until(lambda: seconds() > began + 6.0)
        began = seconds()
        person.type(f"{line}\nnodes\n")
        await person.until("alone up")
        assert person.said.count(said) == 2
        assert seconds() - began < 0.5


@pytest.mark.parametrize(
    ("life", "line", "said", "patience"),
    [
        (Life.UP, "get coming gain", "get: no node /coming is on the graph", 4.9),
        (Life.STARTING, "reset", "reset: reset_encoder is not offered by any node", 14.9),
    ],
)
async def test_a_name_is_waited_for_while_a_program_that_runs_here_comes_up(
    life: Life, line: str, said: str, patience: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with operated(alone) as person:
        host, began = person.station.host, seconds()
        await until(lambda: seconds() > began + 6.0)
        coming = (*host.states(), Hosted("/coming", life))
        monkeypatch.setattr(host, "states", lambda: coming)
        began = seconds()
        await person.enter(f"{line}", f"failed: {said}")
        assert seconds() - began >= patience
        monkeypatch.undo()  # It has ended.
        began = seconds()
        person.type(f"{line}\nnodes\n")
        await person.until("alone up")
        assert seconds() - began < 2.0


class Late(Node):
    """Offers its service and subscribes to `words` 3 s after the start."""

    def __init__(self, **options: Any) -> None:
        super().__init__("late", **options)
        self.timer = self.create_timer(3.0, self.offer)

    def offer(self) -> None:
        self.timer.cancel()
        self.create_service(ResetEncoder, "reset_encoder", self.reset)
        self.create_subscription(String, "words", lambda _: None, 10)

    def reset(
        self, request: ResetEncoder.Request, response: ResetEncoder.Response
    ) -> ResetEncoder.Response:
        response.success, response.message = True, "late is better than never"
        return response


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("reset", "late is better than never"),
        ("pub words data=x --yes", "pub words: published; 1 subscriber\n"),
        ("pub words std_msgs/msg/String data=x --yes", "pub words: published; 1 subscriber\n"),
    ],
)
async def test_what_is_there_some_seconds_after_the_start_is_waited_for(
    line: str, said: str
) -> None:
    async with operated(Late) as person:
        person.station.attached = line != "reset"  # A topic: of a robot elsewhere.
        await person.enter(line, said)
        assert "failed" not in person.said


async def test_a_goal_of_a_robot_that_no_file_names_is_cancelled_at_once() -> None:
    made: list[Hesitant] = []
    async with operated(making(made, Hesitant, "reach")) as person:
        person.type("send_goal reach shelf_number=3\n")
        await until(lambda: made and made[0].seen)
        made[0].answer()
        await person.until("YOU console: reach 3: accepted")
        began = seconds()
        await person.enter("cancel", "goal CANCELLED")
        assert seconds() - began < 0.5


async def test_a_cancel_does_not_wait_until_the_robot_has_taken_the_goal() -> None:
    made: list[Hesitant] = []
    async with operated(making(made, Hesitant)) as person:
        person.type("go 12\ncancel\nnodes\n")
        await until(lambda: made and made[0].seen)
        station, began = person.station, seconds()
        goals = station.robot.goals
        await until(lambda: goals.ours is not None and goals.ours.is_cancelled)
        assert seconds() - began < 1.0
        assert "hesitant up" not in person.said  # what follows keeps its place
        made[0].answer()
        await person.until("goal CANCELLED")
        await person.until("hesitant up")


async def test_a_cancel_in_the_same_pipe_tells_the_queue_once() -> None:
    async with operated(ros_args=LONG) as person:
        person.type("go 12 7\ncancel\n")
        await person.until("queue held: 7 (cancelled)")
        assert await person.end() == 1
    assert person.said.count(" queue: 7\n") + person.said.count(" queue: held: 7 ") == 1


async def test_a_cancel_that_answers_a_question_is_a_no_and_then_a_cancel() -> None:
    async with operated(at_terminal=True) as person:
        await person.enter("go 12", "goal MOVING")
        await person.enter("reset", "[y/N]")
        await person.enter("cancel", "failed: reset: not done: the answer was not yes")
        await person.until("goal CANCELLED")


async def test_that_a_goal_without_an_answer_is_waited_for_is_said() -> None:
    made: list[Hesitant] = []
    async with operated(making(made, Hesitant)) as person:
        person.type_last("go 12\n")
        await person.until("waiting for the end of shelf 12; ctrl+c cancels it")
        assert "goal UNKNOWN" in person.said
        made[0].answer(taken=False)
        assert await person.end() == 1
