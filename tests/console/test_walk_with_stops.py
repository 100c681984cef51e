"""Bytes and lines at random with STOP among them: after the last one nothing moves.

Bytes go through the driver's own reading: keys in chunks, pastes, replies of a terminal cut in two,
floods of mouse moves.
"""

from __future__ import annotations

import asyncio
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from archo_bringup.battery_monitor import BatteryMonitor
from archo_bringup.motor_controller import MotorController

from archo_tui.screen.terminal.keyboard import Keyboard
from archo_tui.screen.terminal.stop_marks import dispatch
from tests.robots.cart import Cart
from tests.support import clock
from tests.support.console import LONG, Console, console
from tests.support.night import corners
from tests.support.plain import Typed, operated
from tests.support.quiet import until, while_passes
from tests.support.robot import making
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
    """Types bytes to a screen, as the driver reads them."""

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

    async def drive(self) -> None:
        for keys in (b"\x1b", b"\x1b", b"R", b"y", b"g12\r"):
            await self.write(keys)
            await self.pause(0.8)

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

    async def stop(self) -> None:
        choose = self._choose
        await self.pause(choose.choice([0.0, 0.15, 0.6]))  # no escape is begun, no paste open
        await self.write(b"\x1b[201~")
        await self.pause(0.15)
        before = self.chunk() if choose.random() < 0.5 else b""
        before = b"" if before[:1] == b"\x1b" else before
        keys = b"".join(choose.choices(_KEYS, k=3))
        await self.write(before + keys + STOP + choose.choice(_ENDS))


_LINES = [
    *(
        "go 12",
        "go 12 7 3",
        "go 99",
        "go x",
        "cancel",
        "release --yes",
        "continue",
        "skip",
        "reset",
    ),
    *("set motor_controller max_speed 0.5", "set nosuch x 1", "blink", "status", "", "nonsense"),
    *("charge", "go 7\r", '"open', "params", "x" * 300),
]
_STOP_LINES = ["stop", "STOP!", "Stop.", " stop now", '"stop"', "stop\r", "\ufeffstop"]


class Liner:
    """Types lines to `--plain`."""

    def __init__(self, person: Typed, choose: random.Random) -> None:
        self._person, self._choose = person, choose
        self.typed: list[str] = []

    def _type(self, *lines: str) -> None:
        self.typed.append("".join(f"{line}\n" for line in lines))
        self._person.type(self.typed[-1])

    async def pause(self, seconds: float) -> None:
        await self._person.is_read()
        await while_passes(seconds)

    async def drive(self) -> None:
        self._type("release --yes", "go 12")
        await self.pause(1.0)

    async def mess(self) -> None:
        choose = self._choose
        for _ in range(choose.randrange(4)):
            lines = choose.choices(_LINES, k=choose.randrange(1, 5))
            if choose.random() < 0.3:
                lines.insert(choose.randrange(len(lines) + 1), choose.choice(_STOP_LINES))
            self._type(*lines)
            if choose.random() < 0.5:
                await self.pause(choose.choice([0.0, 0.1, 0.7]))

    async def stop(self) -> None:
        before = self._choose.choices(_LINES, k=self._choose.randrange(4))
        self._type(*before, self._choose.choice(_STOP_LINES), "status")


_ROUNDS, _FAR = 5, 80


class Robot(NamedTuple):
    """A robot of a walk, and what must hold behind the last STOP."""

    makers: Callable[[list[Any]], list[Any]]
    stands: Callable[[Any], bool]
    ros_args: Sequence[str] = ()
    file: Path | None = None


class Counting(MotorController):
    """Counts its goals: a walk in which nothing drives shows nothing."""

    driven = 0

    async def execute_move(self, goal: Any) -> Any:
        self.driven += 1
        return await super().execute_move(goal)


LATCHING, NOT_LATCHING = "a robot that latches", "a robot that does not latch"
WALKED = {
    LATCHING: Robot(
        lambda made: [BatteryMonitor, making(made, Counting)],
        lambda motor: motor.emergency_stopped and motor.goal is None,
        ros_args=LONG,
    ),
    NOT_LATCHING: Robot(
        lambda made: [making(made, Cart)],
        lambda cart: cart.drives == 0,
        file=ROBOTS / "cart.yaml",
    ),
}


async def walk(
    mouth_of: Callable[[random.Random], Typist | Liner],
    name: str,
    made: list[Any],
    request: pytest.FixtureRequest,
    about: Callable[[], str],
) -> None:
    """Rounds that end with STOP; by night another walk each time, and a long one."""
    far = request.config.getoption("--night")
    seed = random.randrange(10**6) if far else 1 + 2 * [*WALKED].index(name)
    choose = random.Random(seed)
    mouth = mouth_of(choose)
    for number in range(_FAR if far else _ROUNDS):
        mouth.typed.clear()
        if choose.random() < 0.5:
            await mouth.drive()
        await mouth.mess()
        await mouth.stop()
        await mouth.pause(4.0)
        where = f"seed {seed}, round {number}: {mouth.typed}\n{about()}"
        assert WALKED[name].stands(made[-1]), where
    assert made[-1].driven


@pytest.mark.parametrize("name", corners([LATCHING], [NOT_LATCHING]))
async def test_after_the_last_stop_line_nothing_moves(
    name: str, request: pytest.FixtureRequest
) -> None:
    made: list[Any] = []
    robot = WALKED[name]
    async with operated(*robot.makers(made), robot=robot.file, ros_args=robot.ros_args) as person:
        await until(lambda: made)
        about = lambda: person.said[-3000:]  # noqa: E731
        await walk(lambda choose: Liner(person, choose), name, made, request, about)


@pytest.mark.parametrize("name", corners([NOT_LATCHING], [LATCHING]))
async def test_after_the_last_stop_key_nothing_moves(
    name: str, request: pytest.FixtureRequest
) -> None:
    made: list[Any] = []
    robot = WALKED[name]
    given = {"node_makers": robot.makers(made), "robot": robot.file, "wait": False}
    async with console(*robot.ros_args, **given) as op:  # type: ignore[arg-type]
        await op.until(lambda: "emergency_stop" in op.app.view.snapshot.offered)
        await op.until(lambda: op.app.view.snapshot.actions)
        ended: list[int] = []
        op.app.exit = lambda *_, **__: ended.append(1)  # type: ignore[method-assign]
        await walk(lambda choose: Typist(op, choose), name, made, request, lambda: op.text)
        assert not op.session.robot.goals.sending_has_ended, "the walk must not quit"
