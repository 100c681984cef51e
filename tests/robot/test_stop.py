"""STOP: its answers, what follows one without a yes, and what the robot reports behind it."""

from __future__ import annotations

import asyncio
import contextlib
import math
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node
from std_srvs.srv import Empty, SetBool, Trigger

from archo_tui.robot import node
from archo_tui.robot.outcome import Code
from archo_tui.robot.robot import Robot
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Latch, StopAnswer
from archo_tui.robot.stop.gate import NOT_SENT
from archo_tui.robot_file.load import default_path
from archo_tui.text.goal import goal_line
from archo_tui.text.state import motion_word
from tests.support import chosen, clock
from tests.support.alarms import alarms_of
from tests.support.archo import SHELF, go
from tests.support.by_hand import ByHand
from tests.support.plain import operated
from tests.support.quiet import ended, until, while_passes
from tests.support.robot import making, robot, texts
from tests.support.ros import begin
from tests.support.stand_in import Made, Other, StandIn, beside
from tests.support.states import plain_text

Brake = partial(Made, StandIn)
Driver = partial(Made, StandIn, "driver", goals="drive", moving=False)
Wheels = partial(Made, StandIn, release="yes")


def word(it: Robot) -> str:
    return plain_text(motion_word(it.snapshot, clock.seconds(), 80))


# Its answers.


@pytest.mark.parametrize(
    ("says", "code", "said"),
    [
        ("yes", Code.DONE, "yes"),
        ("no", Code.REFUSED, "REFUSED by 1 of 2: b no: use the hardware stop"),
        ("nothing", Code.TIMEOUT, "1 of 2 answered in 3 s: use the hardware stop"),
    ],
)
async def test_one_stop_counts_the_answers_of_all_its_servers_which_are_an_alarm(
    says: str, code: Code, said: str
) -> None:
    a, b = Brake("a", "yes"), Brake("b", says)
    async with robot(a, b) as it:
        await until(lambda: "several stops" in alarms_of(it))
        assert "2 NODES SERVE emergency_stop: /a, /b:" in alarms_of(it)["several stops"]
        assert "hardware stop" in alarms_of(it)["several stops"]
        outcome = await ended(it.emergency_stop())
        assert outcome.code == code
        assert said in outcome.text
        assert all((a.node.stops, b.node.stops))
        assert (it.snapshot.open_stop is None) == outcome.ok
        b.node.wake()


async def test_a_server_that_leaves_without_an_answer_makes_the_stop_uncertain() -> None:
    hangs = Brake("hangs", "nothing")
    async with robot(Brake("brake", "yes"), hangs) as it:
        await until(lambda: "emergency_stop" in it.snapshot.duplicate_servers)
        assert not (await ended(it.emergency_stop())).ok
        begin(hangs.node, hangs.node.destroy_service, hangs.node.service)
        await until(lambda: it.snapshot.open_stop is None)
        assert it.snapshot.latch is Latch.UNCERTAIN
        assert it.snapshot.latch_doubt == "/hangs has left without an answer"
        hangs.node.wake()


@pytest.mark.parametrize("seconds", [(2.5,), (0.0, 3.5)])
async def test_a_stop_that_is_always_answered_late_is_confirmed(seconds: tuple[float]) -> None:
    async with robot(*(Brake(f"brake_{s:.0f}", "yes", seconds=s) for s in seconds)) as it:
        await until(lambda: it.snapshot.battery.received is not None)
        await until(lambda: "emergency_stop" in it.snapshot.offered)
        await until(lambda: len(seconds) == 1 or "emergency_stop" in it.snapshot.duplicate_servers)
        assert not (await ended(it.emergency_stop())).ok
        assert it.snapshot.open_stop
        assert it.snapshot.open_stop.answer == StopAnswer.NONE
        until_then = clock.seconds() + 3.0
        await until(lambda: it.snapshot.open_stop is None or clock.seconds() > until_then)
        assert it.snapshot.open_stop is None
        told = "STOP, answered late: confirmed: brake_"
        await until(lambda: any(text.startswith(told) for text in texts(it)))


async def test_a_stop_that_was_refused_is_sent_again_until_there_is_a_yes() -> None:
    a = Brake("a", "no")
    async with robot(a) as it:
        await until(lambda: it.snapshot.battery.received is not None)
        first = clock.seconds()
        assert not (await ended(it.emergency_stop())).ok
        assert alarms_of(it)["stop not confirmed"] == "STOP REFUSED (a no): use the hardware stop"
        await until(lambda: len(a.node.stops) >= 4)
        assert clock.seconds() - first > 2.9  # a second between two
        repeats = [e for e in it.snapshot.events if e.text == "STOP, sent again: REFUSED: a no"]
        assert [event.count for event in repeats] in ([2], [3])
        a.node.says = "yes"
        await until(lambda: it.snapshot.open_stop is None)
        assert it.snapshot.latch is Latch.HELD
        await until(lambda: "STOP, sent again: confirmed: a yes" in texts(it))
        asked = len(a.node.stops)
        await while_passes(3.0)
        assert len(a.node.stops) == asked


async def test_a_stop_that_is_sent_again_is_not_another_clients() -> None:
    dazed = Made(StandIn, "dazed", "nothing", latches=True, moving=False)
    async with robot(dazed) as it:
        await until(lambda: it.snapshot.motion.received is not None)
        assert not (await ended(it.emergency_stop())).ok
        await while_passes(3.0)
        dazed.node.stopped = True
        await until(lambda: it.snapshot.motion.stopped)
        dazed.node.wake()  # what was sent before is answered, too
        await while_passes(6.0)
        assert not any("another client" in text for text in texts(it))
        told = [text for text in texts(it) if text.startswith(("STOP, ", "STOP: the robot says"))]
        assert told == ["STOP: the robot says that it is stopped"]


async def test_a_stop_waits_for_a_server_that_is_only_just_coming() -> None:
    host = Made(Node, "somebody")
    async with robot(host) as it:
        asked = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        late = beside(host.node, StandIn("late", "yes", context=host.node.context))
        assert (await ended(asked)).text == "confirmed: late yes"
        late.destroy_node()


async def test_a_stop_that_nobody_serves_says_what_is_missing_and_is_not_forgotten() -> None:
    async with robot(Made(Node, "quiet")) as it:
        before = clock.seconds()
        outcome = await ended(it.emergency_stop())
        assert outcome.text == "/emergency_stop is not offered by any node: use the hardware stop"
        assert outcome.code == Code.NOT_OFFERED
        assert clock.seconds() - before >= 2.0
        assert it.snapshot.open_stop is not None
        events = [event.text for event in it.snapshot.events if event.level == "YOU"]
        assert events == [f"STOP: {outcome.text}"]
        released = await ended(it.release_emergency_stop())
        said = "no node has got the STOP, which is given up; nothing was sent"
        assert released == (Code.DONE, said)
        assert it.snapshot.open_stop is None


async def test_an_open_stop_is_sent_once_it_is_served_before_another_poll() -> None:
    host = Made(Node, "somebody")
    async with robot(host) as it:
        assert (await ended(it.emergency_stop())).code == Code.NOT_OFFERED
        it._poller._next = math.inf  # As on a graph of many names, which rests long.
        await until(lambda: host.node.executor is not None)
        late = beside(host.node, StandIn("late", "yes", context=host.node.context))
        await until(lambda: "STOP, sent now: confirmed: late yes" in texts(it))
        assert len(late.stops) == 1
        assert (it.snapshot.open_stop, it.snapshot.latch) == (None, Latch.HELD)
        assert "stop not confirmed" not in alarms_of(it)


@pytest.mark.parametrize("kind", [SetBool, Empty])
async def test_a_stop_of_another_type_is_not_called_and_that_is_said_at_once(kind: Any) -> None:
    called: list[Any] = []

    def stop(request: Any, response: Any) -> Any:
        called.append(request)
        return response

    def stopping(**options: Any) -> Node:
        made = Node("stopping", **options)
        made.create_service(kind, "emergency_stop", stop)
        return made

    async with robot(stopping, offers="emergency_stop") as it:
        outcome = await ended(it.emergency_stop())
        assert it.snapshot.open_stop is not None
        if kind is SetBool:  # called with a default, it would release
            said = "/emergency_stop is std_srvs/srv/SetBool, whose request differs: not called"
            assert called == []
            assert it.snapshot.faults["emergency_stop"].startswith(said)
            assert outcome == (Code.REFUSED, f"{said}: use the hardware stop")
        else:
            said = "answered, not confirmed: use the hardware stop"
            assert outcome == (Code.NOT_CONFIRMED, said)


@pytest.mark.skipif(
    chosen.ENGINE != "embedded", reason="one process cannot have both in Fast DDS, only two can"
)
async def test_a_client_of_another_type_does_not_hide_the_server() -> None:
    both = Brake("both", "yes")
    async with robot(both, offers="emergency_stop") as it:
        both.node.create_client(Empty, "emergency_stop")
        await until(lambda: len(it.graph.services["/emergency_stop"]) == 2)
        assert (await ended(it.emergency_stop())).ok


async def test_a_stop_that_is_called_off_answers_for_none_behind_it() -> None:
    async with robot(Brake("brake", "nothing"), offers="emergency_stop") as it:
        it.stops.register()
        sent = asyncio.ensure_future(it.emergency_stop())
        await asyncio.sleep(0)
        it.stops.register()  # Of the next one, whose work has not begun.
        sent.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await sent
        assert it.stops.answered == 1
        assert not it.stops.are_answered


# Goals behind it.


@pytest.mark.parametrize(("says", "seconds"), [("no", 0), ("nothing", 0), ("yes", 5.0), ("", 0)])
async def test_goals_are_cancelled_whatever_it_answers_those_of_others_after_a_second(
    says: str, seconds: float
) -> None:
    driver, other = Driver(says, seconds=seconds), Made(Other)
    async with robot(driver, other, offers="move_to_shelf") as it:
        assert (await ended(go(it, 9))).ok
        other.node.go(3)
        await until(lambda: it.snapshot.running == 4)
        sent = clock.seconds()
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.running == 0)
        ours, *others = [at - sent for at in driver.node.cancels]
        assert ours < 0.9 < min(others) <= max(others) < 1.5
        assert {goal.phase for goal in it.snapshot.history} == {Phase.CANCELLED}
        said = "STOP was not confirmed in time: cancelling 3 goals of other clients"
        await until(lambda: said in texts(it))
        await while_passes(3.0)
        assert sum("goals of other clients" in text for text in texts(it)) == 1
        driver.node.wake()


async def test_goals_of_other_clients_are_left_to_a_robot_that_says_yes() -> None:
    driver, other = Driver("yes"), Made(Other)
    async with robot(driver, other, offers="move_to_shelf") as it:
        other.node.go()
        await until(lambda: it.snapshot.running == 1)
        assert (await ended(it.emergency_stop())).ok
        await while_passes(3.0)
        assert driver.node.cancels == []
        assert it.snapshot.still_running_after_stop == ("another client's goal",)


async def test_an_action_whose_cancel_moves_the_robot_is_exempt(tmp_path: Path) -> None:
    driver, file = Driver("no"), tmp_path / "exempt.yaml"
    text = default_path().read_text()
    file.write_text(
        text.replace("action: move_to_shelf\n", "action: move_to_shelf\n    stop_cancels: false\n")
    )
    async with robot(driver, robot=file, offers="move_to_shelf") as it:
        assert (await ended(it.send(it.file.goals[0], {"shelf_number": 3}))).ok
        assert not (await ended(it.emergency_stop())).ok
        await while_passes(4.0)
        assert driver.node.cancels == []
        assert it.snapshot.running == 1
        line = plain_text(goal_line(it.snapshot, clock.seconds(), ""))
        assert "STOP does not cancel it" in line


async def test_what_others_send_behind_a_stop_goes_on_even_if_it_is_given_up() -> None:
    driver, other = Driver("no", heeds=False), Made(Other)
    async with robot(driver, other, offers="move_to_shelf") as it:
        other.node.go()
        await until(lambda: it.snapshot.running == 1)
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: driver.node.cancels)
        other.node.go()
        await until(lambda: it.snapshot.running == 2)
        await until(lambda: len(driver.node.cancels) >= 3)
        assert it.snapshot.running == 2
        assert (await ended(it.give_up_stop())).ok
        assert "stop not confirmed" not in alarms_of(it)
        cancels, stops = len(driver.node.cancels), len(driver.node.stops)
        await while_passes(5.0)
        # One of each may have been on its way.
        assert len(driver.node.cancels) <= cancels + 1
        assert len(driver.node.stops) <= stops + 1


async def test_a_stop_that_is_pressed_again_cancels_what_others_have_sent_since() -> None:
    other = Made(Other)
    async with robot(Driver("no"), other, offers="move_to_shelf") as it:
        other.node.go()
        await until(lambda: it.snapshot.running == 1)
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.running == 0)
        other.node.go()
        await until(lambda: it.snapshot.running == 1)
        await while_passes(2.5)
        assert it.snapshot.running == 1  # A repeat is no new word of the operator.
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: it.snapshot.running == 0)


async def test_no_goal_is_sent_behind_a_stop_that_is_not_confirmed() -> None:
    driver = Driver("nothing", release="yes")
    async with robot(driver, offers="emergency_stop move_to_shelf") as it:
        await until(lambda: it.snapshot.motion.received is not None)
        assert not (await ended(it.emergency_stop())).ok
        said = "the STOP is not confirmed: release it first, or give it up"
        assert await ended(go(it, 5)) == (Code.REFUSED, said)
        queued = await ended(it.send(SHELF, {"shelf_number": 3}, queued=True))
        assert queued == (Code.HELD, "held: STOP")
        asked = len(driver.node.stops)
        await until(lambda: len(driver.node.stops) > asked)  # it goes on to be sent
        assert (await ended(it.release_emergency_stop())).ok
        assert (await ended(go(it, 6))).ok
        assert driver.node.shelves == [6]
        assert (await ended(it.cancel())).ok


# What the robot reports is believed where it is the worse news.


async def test_a_robot_that_moves_on_behind_a_confirmed_stop_is_an_alarm() -> None:
    wheels = Wheels("wheels", moving=True)
    async with robot(Brake("brake", "yes"), wheels) as it:
        await until(lambda: it.snapshot.motion.moving)
        assert (await ended(it.emergency_stop())).ok
        await until(lambda: "moves after stop" in alarms_of(it))
        said = "THE ROBOT MOVES ALTHOUGH STOP WAS SENT"
        assert alarms_of(it)["moves after stop"].startswith(said)
        wheels.node.moving = False
        await until(lambda: "moves after stop" not in alarms_of(it))
        await until(lambda: word(it) == "✗ STOP CONFIRMED, not reported by the robot")
        wheels.node.moving = True  # it does not latch: somebody else drives it again
        await while_passes(2.0)
        assert "moves after stop" not in alarms_of(it)
        wheels.node.moving = False
        assert (await ended(it.release_emergency_stop())).ok
        await until(lambda: word(it) == "● IDLE")


async def test_goals_end_behind_a_stop_that_only_the_motion_confirms() -> None:
    wheels, drive = Wheels("wheels", moving=True), Made(StandIn, "drive", goals="drive")
    makers = Brake("brake", "nothing"), wheels, drive
    async with robot(*makers, offers="emergency_stop move_to_shelf") as it:
        assert (await ended(go(it, 5))).ok
        await while_passes(1.0)
        wheels.node.moving, wheels.node.stopped = False, True
        outcome = await ended(it.emergency_stop())
        assert outcome == (Code.DONE, "the robot says that it is stopped")
        await until(lambda: drive.node.cancels)


async def test_a_late_yes_holds_though_it_was_given_up_but_not_behind_a_release() -> None:
    driver = Made(StandIn, "driver", "yes", release="yes", seconds=6.0, goals="drive")
    async with robot(driver, offers="emergency_stop move_to_shelf") as it:
        assert not (await ended(it.emergency_stop())).ok
        assert (await ended(it.give_up_stop())).ok
        assert (await ended(go(it, 3))).ok
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        await until(lambda: driver.node.cancels)  # What it began before that yes ends.
        assert (await ended(it.release_emergency_stop())).ok
        assert not (await ended(it.emergency_stop())).ok
        assert (await ended(it.give_up_stop())).ok
        driver.node.seconds = 0.0
        assert (await ended(it.emergency_stop())).ok
        assert (await ended(it.release_emergency_stop())).ok
        assert it.snapshot.latch is Latch.NONE
        await until(lambda: it.snapshot.latch is Latch.UNCERTAIN)
        assert it.snapshot.latch_doubt == "it was answered behind a release"


async def test_of_two_nodes_that_tell_of_the_motion_none_confirms_a_stop() -> None:
    brake, other = Brake("brake", "nothing"), Wheels("other", moving=False)
    async with robot(brake, Wheels("wheels", moving=True), other) as it:
        await until(lambda: "motor_status" in it.snapshot.publishers)
        other.node.stopped = True
        assert not (await ended(it.emergency_stop())).ok
        await until(lambda: len(brake.node.stops) > 1)  # it is sent again
        await while_passes(6.0)
        assert "stop not confirmed" in alarms_of(it)
        # Readings that come mixed are no doing of another client.
        assert [text for text in texts(it) if "by another client" in text] == []


# A release or a goal that left before a STOP, and that a busy robot takes behind it.

Busy = partial(Made, StandIn, "busy", "yes", release="nothing", latches=True)
BOTH = "emergency_stop release_emergency_stop"


def by_its_key(it: Robot) -> Any:
    return it.release_emergency_stop()


def by_a_form(it: Robot) -> Any:
    return it.call("/release_emergency_stop", "std_srvs/srv/Trigger", {})


@pytest.mark.parametrize(
    ("how", "before", "behind"),
    [(by_its_key, 0.3, 0.0), (by_a_form, 0.3, 0.0), (by_its_key, 3.0, 7.5)],
    ids=["by its key", "by a form", "late"],
)
async def test_a_release_that_is_taken_behind_a_stop_is_followed_by_another_stop(
    how: Any, before: float, behind: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Behind 2 s without an answer the console has given the release up; the robot has not."""
    monkeypatch.setattr(node, "LATE", 2.5)  # what a late answer to a STOP has
    busy = Busy()
    async with robot(busy, offers=BOTH) as it:
        task = asyncio.ensure_future(how(it))
        await until(lambda: busy.node.asked_to_release == 1)
        await while_passes(before)
        it.stops.register()
        assert (await ended(it.emergency_stop())).ok
        await while_passes(behind)
        busy.node.wake()
        await until(lambda: any("sent again behind" in text for text in texts(it)))
        await until(task.done)
        await until(lambda: busy.node.stopped)


async def test_a_release_ends_the_stop_before_it_however_late_it_is_answered() -> None:
    busy = Busy()
    async with robot(busy, offers=BOTH) as it:
        assert (await ended(it.emergency_stop())).ok
        assert (await ended(it.release_emergency_stop())).code == Code.TIMEOUT
        assert it.snapshot.latch is Latch.HELD
        busy.node.wake()
        await until(lambda: it.snapshot.latch is Latch.NONE)
        await while_passes(1.0)
        assert not busy.node.stopped  # It is not followed by another STOP.


async def test_an_earlier_release_does_not_end_a_stop_that_cannot_be_sent() -> None:
    released = Made(StandIn, release="nothing")
    async with robot(released, offers="release_emergency_stop") as it:
        release = asyncio.ensure_future(by_its_key(it))
        await until(lambda: released.node.asked_to_release == 1)
        it.stops.register()
        stop = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        released.node.wake()
        assert (await ended(release)).ok
        assert (await ended(stop)).code == Code.NOT_OFFERED
        assert it.snapshot.open_stop is not None


async def test_a_goal_that_is_accepted_after_a_stop_is_cancelled_at_once() -> None:
    slow = Made(ByHand, "slow", hesitates=True)
    async with robot(slow, offers="move_to_shelf") as it:
        task = asyncio.ensure_future(go(it, 3))
        await until(lambda: slow.node.goal_ids)
        it.stops.register()
        stop = asyncio.ensure_future(it.emergency_stop())
        await until(lambda: it.snapshot.open_stop is not None)
        slow.node.take()
        await until(task.done)
        assert task.result() == (Code.CANCELLED, "accepted after a STOP: cancelling it")
        await until(lambda: slow.node.cancelled)
        await until(lambda: "shelf 3 was accepted after a STOP: cancelling it" in texts(it))
        assert not (await ended(stop)).ok
        assert it.snapshot.open_stop is not None  # A goal from before it does not confirm it.


async def test_a_goal_that_moves_though_a_stop_came_before_its_answer_is_cancelled() -> None:
    slow = Made(ByHand, "slow", hesitates=True)
    async with robot(slow, offers="move_to_shelf") as it:
        task = asyncio.ensure_future(go(it, 3))
        await until(lambda: slow.node.goal_ids)
        it.stops.register()
        assert (await ended(task)).code is Code.TIMEOUT
        begin(slow.node, slow.node.feed, slow.node.goal_ids[0], 9.0)
        await until(lambda: slow.node.cancelled)


async def test_a_goal_typed_before_a_stop_that_was_read_since_is_not_sent() -> None:
    slow = Made(ByHand, "slow", hesitates=True)
    async with robot(slow, offers="move_to_shelf") as it:
        with it.stops.typed_at(it.stops.count):
            it.stops.register()
            outcome = await ended(it.send(SHELF, {"shelf_number": 3}))
            queued = await ended(it.send(SHELF, {"shelf_number": 4}, queued=True))
        assert outcome == (Code.CANCELLED, NOT_SENT)
        assert queued == (Code.HELD, NOT_SENT)  # it waits for the operator's word
        assert slow.node.goal_ids == []
        assert it.snapshot.goal is None


# A STOP whose service takes a request, as the Create 3's: with another one it releases.

FILE = """
version: 1
name: Base
stop: {service: e_stop, request: {data: true}, release: e_stop, release_request: {data: false}}
"""


class Base(Node):
    """Stops when it is sent true, and goes on when it is sent false."""

    KIND: Any = SetBool

    def __init__(self, **options: Any) -> None:
        super().__init__("base", **options)
        self.asked: list[bool] = []
        self.create_service(self.KIND, "e_stop", self.e_stop)

    def e_stop(self, request: Any, response: Any) -> Any:
        self.asked.append(request.data)
        response.success, response.message = True, "stopped" if request.data else "released"
        return response


@pytest.fixture
def file(here: Path) -> Path:
    made = here / "base.yaml"
    made.write_text(FILE)
    return made


async def test_stop_and_release_send_what_the_file_says(file: Path) -> None:
    base = Made(Base)
    async with robot(base, robot=file, offers="e_stop") as it:
        it.stops.register()
        outcome = await ended(it.emergency_stop())
        assert outcome.ok
        assert base.node.asked == [True]
        assert it.snapshot.open_stop is None
        await until(lambda: it.snapshot.latch is Latch.HELD)
        assert (await ended(it.release_emergency_stop())).ok
        assert base.node.asked == [True, False]
        assert it.snapshot.latch is Latch.NONE
        commands = [event.command for event in it.snapshot.events if event.command]
        call = "ros2 service call /e_stop std_srvs/srv/SetBool"
        assert commands == [f"{call} '{{data: true}}'", f"{call} '{{data: false}}'"]


async def test_the_line_of_a_call_is_the_stop_or_asks_as_the_release_does(file: Path) -> None:
    base = Made(Base)
    async with operated(base, robot=file) as person:
        person.type("call e_stop data=true\n")
        await person.until("STOP: confirmed")
        person.type("call e_stop\n")
        await person.until("/e_stop needs data=true (stop) or data=false (release)")
        person.type("call e_stop data=false\n")
        await person.until("failed: call: Release the stop?")
        assert base.node.asked == [True]
        person.type("call e_stop data=false --yes\n")
        await person.until("release stop: released")
        assert base.node.asked == [True, False]
        await person.end("")


class Bare(Base):
    """Has the service, and its request no field."""

    KIND = Trigger


@pytest.mark.parametrize(
    ("file_text", "kind", "said"),
    [
        (FILE, Bare, "/e_stop is std_srvs/srv/Trigger, whose request differs: not called"),
        ("stop: e_stop\n", Base, "/e_stop is std_srvs/srv/SetBool, whose request differs"),
        ("stop: {service: e_stop, request: {on: true}}\n", Base, "whose request differs"),
        ("stop: {service: e_stop, request: {data: 1}}\n", Base, "whose data is boolean"),
    ],
)
async def test_a_request_that_does_not_fit_is_said_and_not_sent(
    here: Path, file_text: str, kind: Any, said: str
) -> None:
    file = here / "robot.yaml"
    file.write_text(file_text)
    base = Made(kind)
    async with robot(base, robot=file) as it:
        await until(lambda: said in it.snapshot.faults.get("e_stop", ""))
        it.stops.register()
        outcome = await ended(it.emergency_stop())
        assert outcome.code is Code.REFUSED
        assert said in outcome.text
        assert outcome.text.endswith("use the hardware stop")
        assert not base.node.asked


async def test_a_node_that_starts_behind_a_stop_is_sent_its_request_first(file: Path) -> None:
    made: list[Base] = []
    async with operated(making(made, Base), robot=file) as person:
        person.type("stop\n")
        await person.until("STOP: confirmed")
        person.type("halt base\nstart base\n")
        await person.until("base was told STOP first, and is stopped")
        assert [node.asked for node in made] == [[True], [True]]
        await person.end("")
