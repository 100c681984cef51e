"""`--plain` in a process of its own, with real pipes."""

from __future__ import annotations

import contextlib
import os
import shlex
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from archo_tui.base.paths import journal_file
from tests.support import chosen, warm
from tests.support.waiting import DEADLINE

FAST = ("--ros-args", "-p", "feedback_period:=0.05", "-p", "time_scale:=75.0")
# 500 s to drive: nothing arrives by itself, however busy the machine is
SLOW = (
    "--ros-args",
    "-p",
    "feedback_period:=0.1",
    "-p",
    "time_scale:=2.0",
    "-p",
    "route_length:=1000.0",
    "-p",
    "publish_period:=0.05",
)


class Script:
    """A script that operates the robot."""

    def __init__(self, *words: str, fresh: bool = False) -> None:
        """`fresh` starts a new interpreter: one that can be suspended and looked at."""
        self.domain = chosen.next_domain()
        environ = {
            "ROS_DOMAIN_ID": str(self.domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF",
        }
        arguments = "-m", "archo_tui", "--engine", chosen.ENGINE, "--plain", *words
        fresh |= "--interfaces" in words  # the loaded process has chosen the engine's packages
        command = [sys.executable, *arguments] if fresh else warm.python(*arguments)
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=os.environ | environ,
        )
        assert self._process.stdout is not None
        os.set_blocking(self._process.stdout.fileno(), False)
        self._said = b""

    @property
    def said(self) -> str:
        """All that was read of what it printed."""
        return self._said.decode(errors="replace")  # a letter may be half there

    @property
    def memory(self) -> int:
        """The bytes that it holds, in an interpreter of its own."""
        pages = Path(f"/proc/{self._process.pid}/statm").read_text().split()[1]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

    def type(self, text: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(text.encode())
        self._process.stdin.flush()

    def _read(self) -> None:
        assert self._process.stdout is not None
        self._said += self._process.stdout.read() or b""

    def until(self, text: str, times: int = 1) -> None:
        """Read until that is said, or said so many times."""

        def is_said() -> bool:
            self._read()
            return self.said.count(text) >= times

        _until(is_said, lambda: f"{text!r}:\n{self.said[-10_000:]}")

    def ready(self) -> None:
        """Wait until the robot has been heard."""
        self.type("status\n")
        self.until("\ngoal No goal yet")

    def until_done(self, text: str) -> None:
        """Wait, without reading, until that is in the journal."""
        file = journal_file()
        _until(lambda: file.exists() and text in file.read_text(), lambda: f"{text!r} in {file}")

    def signal(self, number: int) -> None:
        """As `kill` sends it."""
        self._process.send_signal(number)

    def ends_within(self, seconds: float) -> int:
        """The exit code, without reading what it still wants to say."""
        return self._process.wait(seconds)

    def __enter__(self) -> Script:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave nothing behind."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(BrokenPipeError):
                pipe.close()

    def type_last(self, text: str) -> None:
        """Type it and close the input."""
        assert self._process.stdin is not None
        self._process.stdin.write(text.encode())
        self._process.stdin.close()

    def end(self, typed: str = "") -> int:
        """Type the last lines, close the input, and wait for the end; returns the exit code."""
        assert self._process.stdin is not None
        if not self._process.stdin.closed:
            self.type_last(typed)

        def is_over() -> bool:
            self._read()
            return self._process.poll() is not None

        _until(is_over, lambda: f"the end:\n{self.said[-10_000:]}")
        self._read()
        assert self._process.stdout is not None
        self._process.stdout.close()
        return self._process.returncode


def _until(holds: Callable[[], object], what: Callable[[], str]) -> None:
    end = time.monotonic() + 2 * DEADLINE
    while not holds():
        assert time.monotonic() < end, f"waited for {what()}"
        time.sleep(0.01)


def shell(command: str, **environ: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line of shell with `archo` in it."""
    archo = shlex.join(warm.python("-m", "archo_tui"))
    command = command.replace("archo --plain", f"archo --engine {chosen.ENGINE} --plain")
    given = {"ROS_DOMAIN_ID": str(chosen.next_domain()), "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    return subprocess.run(
        ["sh", "-c", command.replace("archo", archo)],
        capture_output=True,
        check=False,
        timeout=120,
        env=os.environ | given | environ,
    )
