"""What is typed into `--plain`, and what it prints to readers that stall."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from archo_tui.base.clock import Clock
from archo_tui.console.printing import MAX_WAITING, Output
from archo_tui.console.typing import MAX_LINE, MAX_LINES, TOO_LONG, Input, LineSplitter, TypedLine
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.words import is_stop
from tests.support import clock
from tests.support.night import corners
from tests.support.quiet import until
from tests.support.script import Script
from tests.support.waiting import DEADLINE


@contextmanager
def reading(stops: Stops) -> Iterator[tuple[Input, int]]:
    """What reads one end of a pipe, and the other end."""
    read, write = os.pipe()
    typed = Input(read, stops, Clock(), lambda: None, lambda _: None)
    typed.start()
    yield typed, write
    os.close(write)
    while typed.is_reading:  # a descriptor of that number may soon be another's
        time.sleep(clock.LOOK)
    os.close(read)


async def _read(text: bytes) -> tuple[int, list[TypedLine]]:
    """How many STOPs are in it, and the other lines."""
    stops, found, view = Stops(), [], memoryview(text)
    with reading(stops) as (typed, write):
        while view:
            view = view[os.write(write, view) :]
    while line := typed.take():
        found.append(line)
    return stops.count, found


def test_lines_are_cut_at_any_place_and_a_long_one_is_counted_out() -> None:
    text = b"one\n\ntwo \xc3\xbc\n" + b"x" * 100_000 + b"\nafter\n"
    for size in (1, 7, 4096, len(text)):
        lines, found = LineSplitter(), []
        for start in range(0, len(text), size):
            found += lines.feed(text[start : start + size])
        assert found == [b"one", b"", "two ü".encode(), TOO_LONG, b"after"]


@pytest.mark.parametrize(
    "line",
    [
        *(b"stop", b" stop now please", b"\xef\xbb\xbfstop", b"stop\r", b"\rstop"),
        *(b"\0stop\0", b"\xff\xfes\0t\0o\0p\0", b"\tstop"),
        *(b"st\x1b[D\x1b[Cop", b"\x1bOCst\x1b[0mop now", b"\x1b[[Astop", b"\x1b[7$stop"),
        *(b"s\x1btop", b"st\x1b\x1b[Aop", b"\x1bO5Astop", b"\x1b]11;rgb:0/0/0\x07stop"),
        *(b"\x1b]0;a\x1b\\stop", "st\x9bAop".encode()),
        *(b"\x1b[Astop", b"\x1b[200~stop\x1b[201~", b"\xa0stop\xff", b"stop " + b"x" * 100_000),
    ],
)
async def test_stop_is_a_stop_however_it_is_typed(line: bytes) -> None:
    assert await _read(b"go 'x\n" + line + b"\nrelease\n") == (
        1,
        [TypedLine("go 'x", 0), TypedLine("release", 1)],
    )
    assert (await _read(b"release\n" + line))[0] == 1  # the input ends without a line's end


async def test_a_stop_is_counted_before_a_line_read_with_it_is_taken() -> None:
    stops, before = Stops(), list[TypedLine | None]()
    read, write = os.pipe()
    typed = Input(read, stops, Clock(), lambda: None, lambda _: before.append(typed.take()))
    os.write(write, b"go 12\nstop\nrelease\n")
    os.close(write)
    typed.start()
    await until(lambda: typed.has_ended and not typed.is_reading)
    os.close(read)
    assert before == [None]
    assert [typed.take(), typed.take()] == [TypedLine("go 12", 0), TypedLine("release", 1)]


def test_a_line_of_opened_brackets_is_looked_at_in_no_time() -> None:
    assert not is_stop(b"\x1b[@" * 20_000 + b"nonstop")


async def test_a_line_of_64_kib_is_taken_and_a_longer_one_is_not() -> None:
    _, (line, longer) = await _read(b"x" * MAX_LINE + b"\n" + b"x" * (MAX_LINE + 1) + b"\n")
    assert line == TypedLine("x" * MAX_LINE, 0)
    assert longer == TypedLine("", 0, f"a line of more than {MAX_LINE} bytes")


async def test_a_line_in_another_encoding_is_not_guessed_at() -> None:
    _, (line, after) = await _read(b"set cam label Gr\xfcn\nstatus\n")
    assert line == TypedLine(
        "", 0, "a line that is not UTF-8: set cam label Gr\N{REPLACEMENT CHARACTER}n"
    )
    assert after == TypedLine("status", 0)


async def test_each_line_carries_the_stops_that_came_before_it() -> None:
    assert await _read(b"a\nstop\nb\nstop\nstop\nc\n") == (
        3,
        [TypedLine("a", 0), TypedLine("b", 1), TypedLine("c", 3)],
    )


async def test_more_lines_than_can_wait_are_refused_and_stop_is_not() -> None:
    stops = Stops()
    with reading(stops) as (typed, write):
        for _ in range(20):
            os.write(write, b"status\n" * 10_000)
        os.write(write, b"release\nstop\n")
        await until(lambda: stops.count)
        assert typed.overflows == 1
        waited = 0
        while line := typed.take():
            assert line == TypedLine("status", 0)
            waited += 1
        assert waited == MAX_LINES
        os.write(write, b"release\n")
        await until(lambda: typed.has_line_or_end)
        assert typed.take() == TypedLine("release", 1)


class SlowToCount(Stops):
    """Counts a STOP when the test says so."""

    def __init__(self) -> None:
        super().__init__()
        self.reads, self.goes_on = threading.Event(), threading.Event()

    def register(self) -> int:
        self.reads.set()
        self.goes_on.wait(DEADLINE)
        return super().register()


async def test_a_stop_that_was_read_and_is_not_counted_yet_is_still_to_come() -> None:
    stops = SlowToCount()
    with reading(stops) as (typed, write):
        await until(lambda: typed.is_quiet)
        os.write(write, b"stop\n")
        await until(stops.reads.is_set)
        assert not typed.is_quiet
        stops.goes_on.set()
        await until(lambda: typed.is_quiet)
        assert stops.count == 1


@pytest.fixture
def script() -> Iterator[Script]:
    """One whose output nobody has read yet."""
    made = Script()
    yield made
    made.close()


def stall(script: Script) -> None:
    """Have it print more than its pipe holds, and wait until it has done so."""
    script.type("help\n" * 100 + "reset\n")
    script.until_done("Encoder reset")


def test_a_reader_that_stalls_does_not_keep_a_stop_from_the_robot(script: Script) -> None:
    stall(script)
    script.type("stop\n")
    script.until_done("STOP: confirmed")


@pytest.mark.parametrize("number", corners([signal.SIGTERM], [signal.SIGHUP]))
def test_a_signal_ends_it_within_3_s_though_nobody_reads(script: Script, number: int) -> None:
    stall(script)
    script.signal(number)
    assert script.ends_within(3.0) == 128 + number


def test_a_signal_ends_it_within_3_s_while_a_command_waits(script: Script) -> None:
    script.type("status\ncall /nosuch\n")
    script.until("\ngoal No goal yet")
    script.signal(signal.SIGINT)
    assert script.ends_within(3.0) == 128 + signal.SIGINT


def test_a_reader_that_comes_back_is_told_how_much_it_missed(script: Script) -> None:
    script.type("help\n" * 600 + "reset\n")
    script.until_done("Encoder reset")
    script.until("Encoder reset")
    notices = re.findall(
        r"\n\.\.\. \d+ lines were left out: the reader was too slow\n", script.said
    )
    assert len(notices) == 1
    script.type("stop\n")
    script.until("STOP: confirmed")
    assert script.end() == 0


def test_the_end_waits_for_a_slow_reader(script: Script) -> None:
    script.type_last("help\n" * 200 + "reset\n")
    script.until_done("Encoder reset")
    with pytest.raises(subprocess.TimeoutExpired):
        script.ends_within(1.5)
    assert script.end() == 0
    assert script.said.count("\nquit: ") == 200
    assert "Encoder reset" in script.said


async def test_the_oldest_lines_are_left_out_and_never_a_part_of_one() -> None:
    read, write = os.pipe()
    output = Output(write, lambda: None)
    output.start()
    count = 100_000
    for number in range(count):
        output.put(b"line number %06d\n" % number)
    assert not output.has_room
    output.close()
    said = b""
    while not said.endswith(b"%06d\n" % (count - 1)):
        said += os.read(read, 65536)
    lines = said.decode().splitlines()
    notices = [line for line in lines if line.startswith("...")]
    others = [line for line in lines if line not in notices]
    assert all(re.fullmatch(r"line number \d{6}", line) for line in others)
    assert sum(int(notice.split()[1]) for notice in notices) == count - len(others)
    assert MAX_WAITING <= len(said) < MAX_WAITING + 2 * 65536
    await until(lambda: output.is_done)
    for descriptor in (read, write):
        os.close(descriptor)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is looked up in /proc")
@pytest.mark.parametrize("line", corners(["y"], ["stop"]))
def test_memory_is_bounded_whatever_is_typed_without_end(line: str) -> None:
    with Script(fresh=True) as script:
        script.type("reset\n")
        script.until_done("Encoder reset")
        before = script.memory
        for _ in range(5):
            script.type(f"{line}\n" * (100_000 // len(line)))
        assert script.memory - before < 20_000_000
