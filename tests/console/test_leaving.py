"""Questions and their answers; the end of a console, and its restart."""

from __future__ import annotations

import asyncio
import json
import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import Node
from std_srvs.srv import SetBool

from archo_tui.base import handover
from archo_tui.base.handover import Handover
from archo_tui.robot.clients import Requester
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Latch, OpenStop, Snapshot
from archo_tui.screen.commands.base import asking_first
from archo_tui.screen.keyed_app import HELD
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from archo_tui.station.shutdown import RESTART
from archo_tui.verbs.verb import Question
from tests.support import chosen, clock
from tests.support.console import AT_ONCE, FAST, Console, console, key_event
from tests.support.front import Front, front, front_of
from tests.support.quiet import until
from tests.support.stand_in import Made
from tests.support.states import MOTOR, NORMAL, STATES, goal

MOVING = STATES["motor moving"]


def noted(it: Front) -> list[str]:
    """What is noted from now on, and each cancel."""
    found: list[str] = []

    async def cancel(**_: Any) -> Outcome:
        found.append("cancelled")
        return Outcome(Code.REFUSED, "refused")

    it.robot.cancel = cancel
    it.robot.note = lambda level, source, text, command="": found.append(text)
    return found


def one_line(shown: str) -> str:
    return " ".join(shown.replace("┃", " ").split())


async def test_leaving_it_running_does_not_cancel() -> None:
    async with front(MOVING, attached=True) as it:
        said = noted(it)
        assert "Leave it running and quit" in await it.press("q")
        await it.press("y")  # Which of the two that act?
        assert len(it.app.screen_stack) == 2
        await it.press("s")
        assert it.app.screen is it.main
        await it.press("q", "tab", "tab", "enter")
        assert not it.app.is_running
    assert said == ["quit: the goal to shelf 12 is left running"]


@pytest.mark.parametrize(
    ("state", "said"),
    [
        ("motor stopped", "the STOP holds on until R in a console"),
        ("motor stop not confirmed", "once this console has ended nobody repeats it"),
    ],
)
async def test_quitting_while_stopped_says_what_becomes_of_the_stop(state: str, said: str) -> None:
    async with front(STATES[state]._replace(goal=None), attached=True) as it:
        assert said in one_line(await it.press("q"))
        await it.press("escape", "q", "tab", "enter")
        assert not it.app.is_running


async def test_quitting_says_that_what_is_published_ends() -> None:
    async with front() as it:
        published = SimpleNamespace(text="pub /words, at 10 Hz")
        it.robot.publications = SimpleNamespace(active=(published,))
        for state in ("normal", "motor moving"):
            await it.put(STATES[state])
            shown = one_line(await it.press("q"))
            assert "pub /words, at 10 Hz, ends with this console." in shown
            await it.press("escape")
            assert it.app.is_running


async def test_suspending_and_quitting_ask_one_thing_at_a_time() -> None:
    async with front(MOVING) as it:
        said = noted(it)
        for key in ("r", "ctrl+q"):
            await it.press(key)
        assert "Reset encoder now?" in it.text
        assert "answer the question that is asked" in it.text
        await it.press("escape")

        assert "on its way to shelf 12; its nodes would pause." in await it.press("ctrl+z")
        assert "Suspend" not in await it.press("enter")
        assert it.app.screen is it.main

        await it.press("escape", "q")
        assert "Cancel goal and quit" in await it.press("ctrl+z")
        assert len(it.app.screen_stack) == 2

        await it.press("escape")
        assert "Leave it running" not in await it.press("q")
        await it.press("tab", "enter")
        assert not it.app.is_running
    assert "cancelled" in said


async def test_an_answer_is_chosen_by_arrows_or_by_its_first_letter() -> None:
    for keys in (["right", "enter"], ["c"], ["right", "right", "left", "enter"]):
        async with front(MOVING, attached=True) as it:
            said = noted(it)
            assert "first letter" in await it.press("q")
            await it.press(*keys)
            assert not it.app.is_running
        assert "cancelled" in said, keys


@pytest.mark.parametrize("end", ["ctrl+q", "SIGTERM"])
async def test_the_end_waits_for_the_answer_to_a_stop(end: str) -> None:
    async with front(NORMAL) as it:
        answer = asyncio.get_running_loop().create_future()
        it.robot.emergency_stop = lambda: answer
        if end == "ctrl+q":
            await it.write("ctrl+x", "ctrl+q")
        else:
            await it.press("ctrl+x")
            it.app._ending.begin(128 + signal.Signals[end])
            await it.settle()
        assert it.app.is_running
        answer.set_result(Outcome(Code.DONE, "stopped"))
        await it.settle()
        assert not it.app.is_running


@pytest.mark.parametrize("key", ["ctrl+c", "escape"])
async def test_a_key_that_waits_for_no_answer_does_not_wait_behind_keys_that_do(key: str) -> None:
    answer, cancelled = asyncio.Event(), list[bool]()

    async def unanswered(*_: Any, **__: Any) -> Outcome:
        await answer.wait()
        return Outcome(Code.DONE, "done")

    async def cancel(**_: Any) -> Outcome:
        cancelled.append(answer.is_set())
        return Outcome(Code.ACCEPTED, "accepted")

    async with front(MOVING) as it:
        it.robot.set_parameters, it.robot.cancel = unanswered, cancel
        await it.write("4", "enter", "ctrl+u", "2", "enter", "x", "q")
        dialog, late = it.app.screen, key_event(key)
        assert dialog is not it.main
        late.time += HELD
        it.app.post_message(late)
        assert "dropped" in await it.settle()
        if key == "escape":
            assert it.app.screen is it.main
        else:
            assert cancelled == [False]
        answer.set()
        await it.settle()
        assert it.app.screen is it.main  # where neither x nor q came, which would have asked


STOPPED = NORMAL._replace(latch=Latch.HELD, motion=replace(MOTOR, stopped=True))
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


@pytest.mark.parametrize("stopped", [STOPPED, UNCERTAIN, OPEN], ids=["held", "uncertain", "open"])
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
            it.robot.snapshot = STOPPED  # Read, sent and confirmed in this moment.

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


async def test_an_answer_is_for_the_values_and_the_goal_that_were_asked_about() -> None:
    now, sent = [0.0], list[Any]()
    station = SimpleNamespace(clock=SimpleNamespace(monotonic=lambda: now[0]), running_goal=None)
    console: Any = SimpleNamespace(station=station)

    async def send(values: Any) -> Outcome:
        sent.append(values)
        return Outcome(Code.DONE, "")

    station.running_goal = goal(Phase.MOVING).running_goal

    def ask(_: Any) -> Question:
        return Question("", "Sure?", "No", "Yes", station.running_goal)

    ask_or_send = asking_first(console, ask, send)
    for now[0], values in ((0.0, {"x": 1}), (1.0, {"x": 5}), (1.1, {"x": 5})):
        assert (await ask_or_send(values)).text == "Sure? Then send it again."
    now[0], station.running_goal = 2.0, None  # It has ended since.
    assert not (await ask_or_send({"x": 5})).ok
    now[0] = 3.0
    assert (await ask_or_send({"x": 5})).ok
    assert sent == [{"x": 5}]


FILE = """
name: Lamp
battery: {topic: b, types: {std_msgs/msg/Float32: {percentage: data}}}
commands:
  - {id: light, title: Light, key: l, service: light, ask: ASK, toggle: {data: battery.charging}}
"""


class Lamp(Node):
    """`asked` holds what it was sent."""

    def __init__(self, **options: Any) -> None:
        super().__init__("lamp", **options)
        self.asked: list[bool] = []
        self.create_service(SetBool, "light", self.light)

    def light(self, request: Any, response: Any) -> Any:
        self.asked.append(request.data)
        response.success = True
        return response


@asynccontextmanager
async def lamp(
    folder: Path, ask: str = "never", reading: str = "battery.charging"
) -> AsyncIterator[tuple[Console, Lamp]]:
    file, made = folder / "lamp.yaml", Made(Lamp)
    file.write_text(FILE.replace("ASK", ask).replace("battery.charging", reading))
    async with console(robot=file, node_makers=[made], wait=False) as op:
        await op.until(lambda: "light" in op.app.view.snapshot.offered)
        yield op, made.node


async def test_it_is_asked_on_or_off_and_the_safe_answer_changes_nothing(here: Path) -> None:
    async with lamp(here) as (op, node):
        sent: list[bool] = []
        for keys, is_on in ((["enter"], None), (["right"], True), (["right", "right"], False)):
            await op.press("l")
            await op.until("The robot does not report battery.charging: Light or Light off?")
            assert node.asked == sent
            await op.press(*keys, *["enter"] * (is_on is not None))
            sent.extend([] if is_on is None else [is_on])
            await op.until(lambda: node.asked == sent)
            await op.until(lambda: op.app.screen is op.app.main)


async def test_a_toggle_of_no_reading_asks_which_way_and_then_what_the_command_asks(
    here: Path,
) -> None:
    async with lamp(here, "always", reading="ask") as (op, node):
        await op.press("l")
        await op.until("Light or Light off?")
        assert "does not report" not in op.text
        await op.press("right", "right", "enter")
        await op.until("Light off now?")
        assert node.asked == []
        await op.press("y")
        await op.until(lambda: node.asked == [False])
