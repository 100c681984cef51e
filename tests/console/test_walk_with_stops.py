"""Bytes at random with STOP among them: after the last one nothing moves and nothing is released.

Through the driver's own reading of bytes; keys in chunks, pastes, replies of a terminal cut in two,
floods of mouse moves. For a robot whose stop latches, and for one whose stop does not.
"""

from __future__ import annotations

import asyncio
import random
from typing import Any

import pytest
from archo_bringup.battery_monitor import BatteryMonitor
from archo_bringup.motor_controller import MotorController

from archo_tui.terminal.keyboard import Keyboard
from archo_tui.terminal.stop_marks import dispatch
from tests.robots.cart import Cart
from tests.support import clock
from tests.support.console import LONG, Console, console
from tests.support.walks import Counting, length
from tests.terminal.test_stop_is_final import ROBOTS

STOP = b"\x18"
_KEYS = [
    *(b"g", b"g12\r", b"g12 7\r", b"3\r", b"12\r", b"R", b"Ry", b"R\t\r", b"y", b"n", b"\r", b"\t"),
    *(b"r", b"ry", b"c", b"b", b"k", b"a", b"4", b"5", b"s", b"u", b" ", b"1", b"\x1b", b"/m"),
    *(b"\x03", b"\x10", b"relea", b"G", b"C", b"?", b"\x7f", b"0.5", b"\x1b[A", b"\x1b[B", b"d"),
]
_REPLIES = [b"\x1b]11;rgb:1e1e/1e1e/1e1e\x1b\\", b"\x1bP>|XTerm(388)\x1b\\", b"\x1b[?1;2c"]
_REPLIES += [b"\x1b_Gi=31;OK\x1b\\", b"\x1b[?997;1n", b"\x1b[8;24;80t", b"\x1b]52;c;ZzEyDQ==\x07"]
_ENDS = [b"", b"\x1b", b"?", b"1", b"4", *_REPLIES[:3]]  # what may follow the last STOP


class Typist:
    """Sends bytes as the driver does."""

    def __init__(self, op: Console, choose: random.Random) -> None:
        self._op, self._choose = op, choose
        self._keyboard = Keyboard()
        self.typed: list[bytes] = []

    async def write(self, data: bytes) -> None:
        """All in one read."""
        self.typed.append(data)
        self._dispatch(self._keyboard.feed(data, clock.seconds()))
        if self._choose.random() < 0.5:
            await asyncio.sleep(0)  # or what follows comes while this is being done

    async def pause(self, seconds: float) -> None:
        """Nothing is typed meanwhile."""
        end = clock.seconds() + seconds
        while clock.seconds() < end:
            await self._op.at(min(end, clock.seconds() + 0.1))
            self._dispatch(self._keyboard.on_silence(clock.seconds()))
        await self._op.settle()

    def _dispatch(self, messages: Any) -> None:
        app = self._op.app
        dispatch(messages, app, app.stop_typed, app.post_message)

    def chunk(self) -> bytes:
        """Some keys, a paste, a reply, or a flood of the mouse."""
        what = self._choose.random()
        if what < 0.1:
            return b"\x1b[200~" + self._choose.choice([b"12", b"R\ry", STOP, b"3\r"]) + b"\x1b[201~"
        if what < 0.2:
            return self._choose.choice(_REPLIES)
        if what < 0.3:
            moves = (self._choose.randrange(1, 80) for _ in range(200))
            return b"".join(b"\x1b[<35;%d;%dM" % (x, x // 3 + 1) for x in moves)
        return b"".join(self._choose.choices(_KEYS, k=self._choose.randrange(1, 5)))

    async def mess(self) -> None:
        """Chunks in pieces, with a STOP somewhere; the last of them ends all."""
        data = b"".join(self.chunk() for _ in range(self._choose.randrange(1, 6)))
        if self._choose.random() < 0.4:
            at = self._choose.randrange(len(data) + 1)
            data = data[:at] + STOP + data[at:]
        while data:
            length = self._choose.choice([1, 3, 10, len(data)])
            await self.write(data[:length])
            data = data[length:]
            if self._choose.random() < 0.2:
                await self.pause(self._choose.choice([0.02, 0.12, 0.3]))


async def walk(op: Console, seed: int, rounds: int, stands: Any) -> None:
    """Rounds of typing that end with STOP; `stands()` is what must hold then."""
    choose = random.Random(seed)
    ended: list[int] = []
    op.app.exit = lambda *_, **__: ended.append(1)  # type: ignore[method-assign]
    typist = Typist(op, choose)
    for number in range(rounds):
        typist.typed.clear()
        for keys in (b"\x1b", b"\x1b", b"R", b"y", b"g12\r") if choose.random() < 0.5 else ():
            await typist.write(keys)
            await typist.pause(0.8)
        await typist.mess()
        await typist.pause(choose.choice([0.0, 0.15, 0.6]))  # no escape is begun, no paste open
        await typist.write(b"\x1b[201~")
        await typist.pause(0.15)
        before = typist.chunk() if choose.random() < 0.5 else b""
        keys = b"".join(choose.choices(_KEYS, k=3))
        await typist.write(
            (before if before[:1] != b"\x1b" else b"") + keys + STOP + choose.choice(_ENDS)
        )
        await typist.pause(3.5)
        assert not op.session.robot.goals.sending_has_ended, "the walk must not quit"
        assert stands(), f"seed {seed}, round {number}: {typist.typed}\n{op.text}"
        await typist.pause(1.0)


@pytest.mark.parametrize("which", [1])
async def test_after_the_last_stop_a_robot_that_latches_stays_stopped(
    which: int, request: pytest.FixtureRequest
) -> None:
    made: list[Counting] = []

    def motor(**given: Any) -> MotorController:
        made.append(Counting(**given))
        return made[-1]

    async with console(*LONG, node_makers=(BatteryMonitor, motor), wait=False) as op:
        await op.until(lambda: op.app.view.snapshot.motion.received is not None)
        await op.until(lambda: len(op.app.view.snapshot.parameters) > 10)
        await walk(
            op,
            *length(which, request),
            lambda: made[-1].emergency_stopped and made[-1].goal is None,
        )
        assert made[-1].driven


@pytest.mark.parametrize("which", [3])
async def test_after_the_last_stop_a_robot_that_does_not_latch_stands(
    which: int, request: pytest.FixtureRequest
) -> None:
    made: list[Cart] = []

    def cart(**given: Any) -> Cart:
        made.append(Cart(**given))
        return made[-1]

    async with console(node_makers=(cart,), robot=ROBOTS / "cart.yaml", wait=False) as op:
        await op.until(lambda: "emergency_stop" in op.app.view.snapshot.offered)
        await op.until(lambda: op.app.view.snapshot.actions)
        await walk(op, *length(which, request), lambda: made[-1].drives == 0)
        assert made[-1].driven
