"""`--plain` for ears: a change is one line, nothing is said twice, what is missing at once."""

from __future__ import annotations

import re
from typing import Any

import pytest
from archo_interfaces.srv import ResetEncoder
from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Hosted, Life, Snapshot
from archo_tui.text import line_by_line
from archo_tui.text.state import motion_word
from tests.support.clock import NOW, seconds
from tests.support.console import FAST, LONG
from tests.support.hesitant import Hesitant
from tests.support.plain import operated, plain, typing
from tests.support.quiet import until
from tests.support.robot import making
from tests.support.states import BATTERY, NORMAL, STATES, goal
from tests.support.stub import StandingClock, StubRobot, stub_station


def lines(said: str) -> list[str]:
    """What is said, without the times of day."""
    return [re.sub(r"^\d\d:\d\d:\d\d ", "", line) for line in said.splitlines()]


def check_is_for_ears(said: str) -> None:
    """No glyph, no column, no row of a table, and no line twice."""
    found = lines(said)
    plain = [re.sub("'[^']*'", "", line) for line in found]  # in quotes anything is typed
    assert [
        line
        for line in plain
        if re.search(r"[●○✗✓▲▶↯█─|]|->|  |\t|--(?!yes|all|follow|rate|times)", line)
    ] == []
    assert sorted(set(found)) == sorted(found), said


async def test_a_drive_is_told_once_at_its_start_each_quarter_and_its_end() -> None:
    code, said = await plain("go 12\n", ros_args=["-p", "feedback_period:=0.02"])
    assert code == 0
    check_is_for_ears(said)
    begun, *quarters, ended = lines(said)
    assert begun == "YOU console: go to shelf 12: accepted"
    assert ended.startswith("goal ARRIVED, Arrived at shelf 12, 18.0 m in")
    left = [float(re.match(r"goal MOVING to 12, (\d+\.\d) m left", line)[1]) for line in quarters]  # type: ignore[index]
    assert [int(4 - metres / 4.5001) for metres in left] == [0, 1, 2, 3]


async def test_a_drive_with_queue_stop_and_low_battery_repeats_nothing() -> None:
    soon_low = ("-p", "battery_monitor:low_battery_threshold:=80.0")
    async with operated(ros_args=(*LONG, *soon_low), use_sim=True) as person:
        await person.enter("go 12 7", "m left of")
        await person.enter("reset", "(add --yes to do it)")
        await person.until("alarm unacknowledged: LOW BATTERY")
        await person.enter("ack", "acknowledged: low battery")
        await person.enter("stop", "alarm unacknowledged: STOPPED")
        await person.enter("status", "queue held: 7 (STOP)")
        await person.enter("go 3", "failed: go: emergency stop: release it first")
        await person.enter("release --yes", "alarm over, unacknowledged: stopped\n")
        await person.enter("status", "alarm over, unacknowledged: STOPPED: look for")
        assert await person.end("skip\n") == 1
    # what happens has its time; what is asked for may be told again
    told = "\n".join(re.findall(r"^\d\d:\d\d:\d\d .*", person.said, re.MULTILINE))
    check_is_for_ears(told)
    assert [line for line in lines(told) if "shelf 3" in line] == []
    assert len([line for line in lines(told) if "release it first" in line]) == 1


async def test_a_battery_that_falls_empty_is_never_called_normal() -> None:
    low = NORMAL._replace(battery=BATTERY._replace(percentage=12.0, health="warning"))
    empty = NORMAL._replace(battery=BATTERY._replace(percentage=0.0, health="warning"))
    robot, standing = StubRobot(low), StandingClock()
    async with typing(stub_station(robot, standing)) as person:
        await until(lambda: robot.listening)
        for standing.passed, snapshot in ((2.1, low), (2.2, empty), (4.3, empty)):
            now = snapshot.battery._replace(received=standing.monotonic())
            robot.put(snapshot._replace(battery=now))
        await person.until("alarm unacknowledged: BATTERY EMPTY")
        await person.until("alarm replaced by a graver one: low battery")
    assert "alarm normal" not in person.said


@pytest.mark.parametrize("verb", ["status", "nodes", "params", "history", "help"])
async def test_what_is_listed_is_a_fact_a_line_in_words(verb: str) -> None:
    code, said = await plain(f"go 12\nset motor_controller max_speed 0.5\n{verb}\n", ros_args=FAST)
    assert code == 0
    # what happens has its time; what is asked for may be told again
    happened = re.findall(r"^\d\d:\d\d:\d\d .*", said, re.MULTILINE)
    check_is_for_ears("\n".join(happened))
    check_is_for_ears("\n".join(line for line in said.splitlines() if line not in happened))


async def test_the_state_is_read_out_without_a_table() -> None:
    _, said = await plain("status\n")
    assert lines(said) == [
        "battery GOOD, 87.5 %, 24.1 V",
        "motor IDLE, 15420 ticks, 0.00 m/s x 7.5",
        "goal No goal yet. Type go and the shelf number.",
    ]


@pytest.mark.parametrize("name", STATES)
def test_every_state_has_words_of_its_own(name: str) -> None:
    snapshot: Snapshot = STATES[name]
    for said in (line_by_line.battery_text(snapshot, NOW), line_by_line.motion_text(snapshot, NOW)):
        assert re.match(r"\w", said)
        assert "--" not in said


@pytest.mark.parametrize(
    ("phase", "changes", "said"),
    [
        (Phase.LOST, {}, "LOST, shelf 12, nothing heard for 0.0 s; the robot may still be moving"),
        (Phase.ABORTED, {"message": "broken"}, "ABORTED, shelf 12, broken"),
        (Phase.ABORTED, {"message": ""}, "ABORTED, shelf 12"),
        (Phase.CANCELLED, {"message": "off", "remaining": None}, "CANCELLED, shelf 12, off"),
        (Phase.CANCELLED, {"message": "off"}, "CANCELLED, off, 9.0 m before shelf 12"),
        (
            Phase.ARRIVED,
            {"message": "Arrived at shelf 12", "ended": NOW},
            "ARRIVED, Arrived at shelf 12, 18.0 m in 1.5 s",
        ),
        (
            Phase.ARRIVED,
            {"message": "there", "ended": NOW, "mine": False},
            "ARRIVED, another client's goal, there, 18.0 m in 1.5 s",
        ),
    ],
)
def test_the_end_of_a_goal_says_once_which_one_it_was(
    phase: Phase, changes: Any, said: str
) -> None:
    assert line_by_line.goal_text(goal(phase, **changes), NOW, "") == said


def test_old_readings_are_not_read_out_as_if_they_were_of_now() -> None:
    later = NOW + 60.0
    assert line_by_line.battery_text(NORMAL, later) == "GOOD, 87.5 %, old, 60 s"
    assert line_by_line.motion_text(NORMAL, later) == line_by_line.spans_to_text(
        motion_word(NORMAL, later, 80)
    )


def test_a_queue_says_what_waits_and_why_it_is_held() -> None:
    assert line_by_line.queue_text(["7", "3"], "") == "7, 3"
    assert line_by_line.queue_text(["7", "3"], "cancelled") == "held: 7, 3 (cancelled)"
    assert line_by_line.queue_text([], "") == ""


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
                ("call blink", "failed: call: no service is on the graph"),
                ("cancel", "failed: cancel: no goal is running"),
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
