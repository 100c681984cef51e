"""What is typed into `--plain`: where lines end, which are STOPs, and how many may wait."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from archo_tui.plain_input import Input, Line
from archo_tui.plain_lines import LONGEST, TOO_LONG, Lines, is_stop
from archo_tui.robot.stops import Stops
from tests.support.quiet import until


@contextmanager
def reading(stops: Stops) -> Iterator[tuple[Input, int]]:
    """What reads one end of a pipe, and the other end."""
    read, write = os.pipe()
    typed = Input(read, stops, lambda: None)
    typed.start()
    yield typed, write
    os.close(write)
    os.close(read)


async def _read(text: bytes) -> tuple[int, list[Line]]:
    """How many STOPs are in it, and the other lines."""
    stops = Stops()
    read, write = os.pipe()
    typed = Input(read, stops, lambda: None)
    typed.start()
    view = memoryview(text)
    while view:
        view = view[os.write(write, view) :]
    os.close(write)
    found = []
    await until(lambda: typed.has_ended)
    while line := typed.take():
        found.append(line)
    os.close(read)
    return stops.count, found


def test_lines_are_cut_at_any_place_and_a_long_one_is_counted_out() -> None:
    text = b"one\n\ntwo \xc3\xbc\n" + b"x" * 100_000 + b"\nafter\n"
    for size in (1, 7, 4096, len(text)):
        lines, found = Lines(), []
        for start in range(0, len(text), size):
            found += lines.take(text[start : start + size])
        assert found == [b"one", b"", "two ü".encode(), TOO_LONG, b"after"]


@pytest.mark.parametrize(
    "line",
    [
        *(
            b"stop",
            b"STOP",
            b"Stop.",
            b"STOP!",
            b" stop now please",
            b"stop;",
            b'"stop"',
            b"'Stop'",
        ),
        *(
            b"\xef\xbb\xbfstop",
            b"stop\r",
            b"\rstop",
            b"\0stop\0",
            b"\xff\xfes\0t\0o\0p\0",
            b"\tstop",
        ),
        *(b"\x1b[Astop", b"\x1b[200~stop\x1b[201~", b"\xa0stop\xff", b"stop " + b"x" * 100_000),
    ],
)
async def test_stop_is_a_stop_however_it_is_typed(line: bytes) -> None:
    assert await _read(b"go 'x\n" + line + b"\nrelease\n") == (
        1,
        [Line("go 'x", 0), Line("release", 1)],
    )
    assert (await _read(b"release\n" + line))[0] == 1  # the input ends without a line's end


@pytest.mark.parametrize(
    "line",
    [b"stopped", b"don't stop", b"stop2", b"help stop", b"stop_it", "stopé".encode(), b"st op"],
)
def test_what_only_contains_the_word_is_no_stop(line: bytes) -> None:
    assert not is_stop(line)


def test_a_line_of_opened_brackets_is_looked_at_in_no_time() -> None:
    assert not is_stop(b"\x1b[@" * 20_000 + b"nonstop")


async def test_a_line_of_64_kib_is_taken_and_a_longer_one_is_not() -> None:
    _, (line, longer) = await _read(b"x" * LONGEST + b"\n" + b"x" * (LONGEST + 1) + b"\n")
    assert line == Line("x" * LONGEST, 0)
    assert longer == Line("", 0, f"a line of more than {LONGEST} bytes")


async def test_a_line_in_another_encoding_is_not_guessed_at() -> None:
    _, (line, after) = await _read(b"set cam label Gr\xfcn\nstatus\n")
    assert line == Line(
        "", 0, "a line that is not UTF-8: set cam label Gr\N{REPLACEMENT CHARACTER}n"
    )
    assert after == Line("status", 0)


async def test_each_line_carries_the_stops_that_came_before_it() -> None:
    assert await _read(b"a\nstop\nb\nstop\nstop\nc\n") == (
        3,
        [Line("a", 0), Line("b", 1), Line("c", 3)],
    )


async def test_more_than_a_megabyte_of_lines_is_refused_and_stop_is_not() -> None:
    stops = Stops()
    with reading(stops) as (typed, write):
        for _ in range(20):
            os.write(write, b"status\n" * 10_000)
        os.write(write, b"release\nstop\n")
        await until(lambda: stops.count)
        assert typed.overflows == 1
        waited = 0
        while line := typed.take():
            assert line == Line("status", 0)
            waited += 1
        assert waited == 1024 * 1024 // len("status")
        os.write(write, b"release\n")
        await until(lambda: typed.has_news)
        assert typed.take() == Line("release", 1)
