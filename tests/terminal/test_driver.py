"""The driver of a terminal: whole frames in bounds, the modes always, keys with their times."""

from __future__ import annotations

import asyncio
import os
import pty
import select
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
from textual.message import Message

from archo_tui.screen.terminal.driver import MAX_WAITING, SteadyDriver, TerminalWriter
from archo_tui.screen.terminal.stop_marks import typed_after
from tests.support.waiting import DEADLINE, wait_until

FILLING = 7  # frames


class Pipe:
    """A terminal that reads when told."""

    def __init__(self) -> None:
        self.read_end, write_end = os.pipe()
        self.drained, self.dead = threading.Event(), threading.Event()
        self.writer = TerminalWriter(write_end, self.drained.set, self.dead.set)
        self.writer.start()
        self.write_end = write_end

    def read(self, end: bytes) -> bytes:
        """Everything up to an end."""
        data = b""
        while not data.endswith(end):
            ready, _, _ = select.select([self.read_end], [], [], 2 * DEADLINE)
            assert ready, f"waited for {end!r}, after {data[-100:]!r}"
            data += os.read(self.read_end, 65536)
        return data

    def fill(self) -> None:
        """Write more than a pipe takes: the writer holds the last frame, and cannot go on."""
        for number in range(FILLING):
            self.writer.write(frame(number))
            wait_until(lambda: self.writer._size == 0)

    def close(self) -> None:
        self.writer.kill()
        for descriptor in (self.read_end, self.write_end):
            if descriptor >= 0:
                os.close(descriptor)


@pytest.fixture
def pipe() -> Iterator[Pipe]:
    made = Pipe()
    yield made
    made.close()


def frame(number: int) -> str:
    return f"<{number:05}{'x' * 10_000}>"


def test_what_is_read_at_once_comes_whole_and_in_order(pipe: Pipe) -> None:
    pipe.writer.write("a")
    pipe.writer.write("b")
    assert pipe.read(b"b") == b"ab"
    assert not pipe.drained.is_set()


def test_frames_are_dropped_whole_and_the_screen_is_told_when_there_is_room(pipe: Pipe) -> None:
    pipe.fill()
    for number in range(FILLING, 1000):
        pipe.writer.write(frame(number))
        assert pipe.writer._size <= MAX_WAITING
    pipe.writer.write("<modes>", keep=True)
    seen = pipe.read(b"<modes>").decode()
    numbers = [int(part[:5]) for part in seen.split("<")[1:-1]]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) < 20
    assert all(len(part) == 10_006 for part in seen.split("<")[1:-1])
    wait_until(pipe.drained.is_set)
    pipe.writer.write("<now>")
    assert pipe.read(b">") == b"<now>"


def test_a_terminal_that_is_gone_is_told_once_and_takes_everything(pipe: Pipe) -> None:
    os.close(pipe.read_end)
    pipe.read_end = -1
    pipe.writer.write("a")
    wait_until(pipe.dead.is_set)
    for number in range(100):
        pipe.writer.write(frame(number), keep=True)
    assert pipe.writer._size == 0
    pipe.writer.stop()
    assert not pipe.writer.is_alive()


def test_the_end_waits_for_what_is_read_and_not_for_what_is_not(pipe: Pipe) -> None:
    pipe.fill()
    pipe.writer.stop()
    assert pipe.writer.is_alive()  # it still holds what nobody reads, and nobody waits for it
    pipe.read(b">")


def test_a_frame_of_any_size_is_written_when_little_waits(pipe: Pipe) -> None:
    large = "x" * (3 * MAX_WAITING)
    for part in ("<begin>", large, "<end>"):  # as Textual writes a frame
        pipe.writer.write(part)
    assert pipe.read(b"<end>") == f"<begin>{large}<end>".encode()
    assert not pipe.drained.is_set()


def test_a_terminal_that_takes_nothing_is_known_to_show_nothing(pipe: Pipe) -> None:
    pipe.writer.write(frame(0))
    pipe.read(b">")
    assert not pipe.writer.is_stuck
    pipe.fill()
    wait_until(lambda: pipe.writer.is_stuck)
    pipe.read(frame(FILLING - 1).encode())
    wait_until(lambda: not pipe.writer.is_stuck)


class Reader:
    """An app for a driver; what reads its keys stands still while it is told to."""

    stop_key = "ctrl+x"

    def __init__(self) -> None:
        self.goes_on, self.stands = threading.Event(), threading.Event()
        self.stops = type("Stops", (), {"count": 0})

    def is_stop(self, _: Message) -> bool:
        self.stands.set()
        self.goes_on.wait(DEADLINE)
        return False


async def test_a_key_that_is_read_late_may_be_as_old_as_the_last_look() -> None:
    read: list[tuple[float, float]] = []  # When at the earliest it was typed, and when read.

    class Driver(SteadyDriver):
        def process_message(self, message: Message) -> None:
            read.append((typed_after(message) or 0.0, time.monotonic()))

    app: Any = Reader()
    driver = Driver(app)
    terminal, driver.fileno = pty.openpty()
    thread = threading.Thread(target=driver.run_input_thread)
    thread.start()
    try:
        os.write(terminal, b"\n")
        await asyncio.to_thread(app.stands.wait, DEADLINE)
        second = time.monotonic()
        os.write(terminal, b"\n")
        app.goes_on.set()
        await asyncio.to_thread(wait_until, lambda: len(read) == 2)
        assert read[1][0] <= second
        silent = time.monotonic()
        await asyncio.to_thread(wait_until, lambda: driver._empty_at > silent)
        os.write(terminal, b"\n")
        await asyncio.to_thread(wait_until, lambda: len(read) == 3)
        assert silent < read[2][0] <= read[2][1]
    finally:
        driver.exit_event.set()
        thread.join(DEADLINE)
        os.close(terminal)
        os.close(driver.fileno)
