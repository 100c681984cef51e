"""What `--plain` prints, to readers that stall: nothing waits for them, and nobody hangs."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from archo_tui.console.printing import MAX_WAITING, Output
from tests.support.night import corners
from tests.support.quiet import until
from tests.support.script import Script


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
