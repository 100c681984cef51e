"""STOP at the seams: beside dialogs that go, in floods, under another key."""

from __future__ import annotations

import asyncio
from contextlib import AbstractAsyncContextManager
from typing import Any

import pytest
from textual.widgets import Button

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screen.terminal.keyboard import Keyboard
from archo_tui.screen.terminal.stop_marks import dispatch, mark_stops, marks_of
from archo_tui.session.session import _robots_nodes
from tests.support.clock import LOOK, seconds
from tests.support.console import FAST, console, key_event
from tests.support.front import Front, front_of
from tests.support.night import corners
from tests.support.peer import Peer
from tests.support.quiet import ended
from tests.support.stand_in import Made, StandIn
from tests.support.states import STATES
from tests.support.stub import StandingClock


class Screen(Front):
    """Bytes in, what the robot was asked for out."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.asked: list[str] = []
        self.ended: list[int] = []
        for verb in ("emergency_stop", "release_emergency_stop", "command"):
            setattr(self.robot, verb, self._verb(verb))
        self.app.exit = lambda *_, **__: self.ended.append(1)  # type: ignore[method-assign]
        self._keyboard = Keyboard(self.app.stop_key)
        self._now = 0.0

    def _verb(self, name: str) -> Any:
        async def ask(*_: Any, **__: Any) -> Outcome:
            gate = self.app.stops.gate()
            if name != "emergency_stop" and gate.is_shut:
                return Outcome(Code.REFUSED, "not sent")
            self.asked.append(name)
            return Outcome(Code.DONE, "done")

        return ask

    def feed(self, data: bytes) -> None:
        """In one read."""
        app = self.app
        dispatch(self._keyboard.feed(data, self._now), app, app.stop_typed, app.post_message)

    async def type(self, *reads: bytes, pause: float = 1.0) -> None:
        for data in reads:
            self._now += pause
            self.feed(data)
            await self.settle()

    @property
    def stop_click(self) -> bytes:
        region = self.main.query_one("#stop", Button).region
        place = b"0;%d;%d" % (region.x + 2, region.y + 1)
        return b"\x1b[<" + place + b"M\x1b[<" + place + b"m"


def screen(state: str, **options: Any) -> AbstractAsyncContextManager[Screen]:
    return front_of(Screen, STATES[state], **options)


async def test_a_click_on_stop_acts_whatever_stands_or_goes_in_front() -> None:
    async with screen("motor stopped") as it:
        for opened, typed in ((b"R", b""), (b"R", b"y"), (b"R", b"\x1b"), (b"", b"R"), (b"", b"")):
            await it.type(opened)  # a question, which is not where STOP is
            it.feed(typed + it.stop_click)
            await it.settle()
            assert it.asked == ["emergency_stop"]
            it.asked.clear()


async def test_a_second_stop_with_a_key_between_is_sent_at_once() -> None:
    async with screen("motor stopped") as it:
        await it.type(b"\x18", b"R", b"y", b"\x18", pause=0.0)
        assert it.asked == ["emergency_stop", "release_emergency_stop", "emergency_stop"]


async def test_a_command_behind_a_stop_waits_for_no_answer_from_before_it() -> None:
    async with screen("motor stopped") as it:
        answer, asked = asyncio.Event(), []

        async def unanswered(*_: Any, **__: Any) -> Outcome:
            asked.append(it.app.stops.gate().is_shut)
            await answer.wait()
            return Outcome(Code.DONE, "done")

        it.robot.command = unanswered
        await it.type(b"c", b"c", b"\x18", b"c", b"c")
        assert asked == [False, False]  # the second one of each pair has to wait
        answer.set()


@pytest.mark.parametrize("opened", [b"\x10", b"R"])
async def test_what_was_typed_for_a_dialog_that_stop_closed_is_no_command(opened: bytes) -> None:
    async with screen("motor stopped") as it:
        await it.type(opened, b"qac\x18")
        assert it.asked == ["emergency_stop"]
        assert not it.ended
        assert it.app.screen is it.main


@pytest.mark.parametrize("kind", corners(["the mouse", "letters"], ["arrows"]))
async def test_stop_has_its_turn_in_a_flood(kind: str) -> None:
    wheel = b"".join(b"\x1b[<%d;5;5M" % (64 + number % 2) for number in range(1200))
    flood = {"the mouse": wheel, "letters": b"xy" * 600, "arrows": b"\x1b[A\x1b[B" * 600}[kind]
    async with screen("motor moving") as it:
        handled = 0
        on_event = it.app.on_event

        async def counted(event: Any) -> None:
            nonlocal handled
            handled += not it.asked
            await on_event(event)

        it.app.on_event = counted  # type: ignore[method-assign]
        it.feed(flood)
        it.app._loop.call_soon(it.feed, b"\x18")  # type: ignore[union-attr]  # as the driver does
        await it.settle()
        assert it.asked == ["emergency_stop"]
        assert handled < 300


async def test_another_key_of_stop_ends_a_paste_whose_end_is_lost() -> None:
    async with screen("motor moving", keys={"stop": "f5"}) as it:
        await it.type(b"\x1b[200~some text", b"\x1b[15~")
        assert it.asked == ["emergency_stop"]


async def test_a_letter_behind_a_refused_enter_is_text() -> None:
    async with screen("normal") as it:
        for behind in "cqr":
            await it.type(b"g", b"\x15", b"1x\r" + behind.encode())
            assert it.main.goal.fields[0].value == f"1x{behind}"
            assert not it.asked
            assert not it.ended


async def test_a_stop_pressed_again_behind_anothers_release_is_sent() -> None:
    slow = Made(StandIn, "slow", "yes", release="nothing", latches=True, moving=False)
    async with console(node_makers=[slow], wait=False) as op:
        slow.node.stopped = True
        await op.until("STOPPED")
        await op.press("ctrl+x")
        release = asyncio.ensure_future(op.session.robot.release_emergency_stop())  # by a shell
        await asyncio.sleep(0)
        while not slow.node.asked_to_release:
            await asyncio.sleep(LOOK)
        op.send("ctrl+x")  # the same key, and the screen still shows STOPPED
        await op.settle()
        slow.node.wake()
        assert (await ended(release)).ok
        later = seconds() + 1.0
        await op.at(later)
        assert slow.node.stopped


async def test_a_question_from_before_another_consoles_stop_is_closed() -> None:
    peer = Made(Peer)
    async with console(*FAST, node_makers=[*_robots_nodes(False).values(), peer]) as op:
        await op.until("2 consoles")
        await op.press("ctrl+x")
        await op.until("✗ STOPPED")
        await op.press("R")
        await op.until("Release the stop?")
        peer.node.tell("stop")
        await op.until("stop: done")
        assert "Release the stop?" not in op.text
        await op.press("y")  # for the question
        await op.settle()
        assert op.app.view.snapshot.motion.stopped


class _Later(StandingClock):
    """It stands where a test puts it."""

    later = 0.0

    def monotonic(self) -> float:
        return super().monotonic() + self.later


async def test_a_key_from_before_a_stop_is_dropped_however_late_it_comes() -> None:
    clock = _Later()
    async with screen("normal", clock=clock) as it:
        it.app.stops.register()
        it.app.closed_by_stop("STOP closed the dialog")
        clock.later = 60.0  # So slow a machine: what was typed for the dialog comes now.
        for stops in (0, 1):
            key = key_event("question_mark")  # It is no command to the robot, which the gate holds.
            mark_stops(key, stops)
            it.app.post_message(key)
            await it.settle()
            assert (it.app.screen is it.main) == (stops == 0)


async def test_what_a_key_leaves_in_a_queue_is_void_behind_a_later_stop() -> None:
    async with screen("normal") as it:
        shut = list[bool]()
        for typed in (b"", b"\x18g", b"\x1b"):
            await it.type(typed, pause=0.0)
            key = key_event("g")
            mark_stops(key, 0)  # It was read before the STOP, and is handled late.
            with marks_of(key, it.app):  # In its turn, a widget posts a message.
                it.main.goal.call_later(lambda: shut.append(it.app.stops.gate().is_shut))
            await it.settle()
        assert shut == [False, True, True]
