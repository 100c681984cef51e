"""Tests of the real ROS 2 between processes, on this machine's loopback only."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest

from tests.support import chosen
from tests.support.waiting import DEADLINE


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if chosen.ENGINE != "ros2":
        reason = "needs the real rclpy: run with --engine ros2 where it is installed"
        for item in items:
            if "/ros2/" in item.path.as_posix():
                item.add_marker(pytest.mark.skip(reason=reason))


class Processes:
    """Nodes in processes of their own, on one domain."""

    def __init__(self) -> None:
        self.domain = chosen.next_domain()
        self._running: list[subprocess.Popen[bytes]] = []

    @property
    def environment(self) -> dict[str, str]:
        """The variables of a process on the domain."""
        return {**os.environ, "ROS_DOMAIN_ID": str(self.domain)}

    def start(self, module: str, *words: str) -> subprocess.Popen[bytes]:
        """Run a node's main()."""
        return self._start(subprocess.DEVNULL, module, "--ros-args", *words)

    def start_console(self, *words: str) -> subprocess.Popen[bytes]:
        """Run a console; its commands are written to its stdin."""
        return self._start(subprocess.PIPE, "archo_tui", "--engine", "ros2", *words)

    def _start(self, stdin: int, module: str, *words: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [sys.executable, "-m", module, *words],
            env=self.environment,
            stdin=stdin,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._running.append(process)
        return process

    def begin(self, *words: str, **options: Any) -> subprocess.Popen[str]:
        """Begin the console's command line, with options of `Popen`."""
        given = {"env": self.environment, **options}
        pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
        command = [sys.executable, "-m", "archo_tui", *words]
        return subprocess.Popen(command, text=True, **(pipes | given))

    def run(self, *words: str, typed: str = "", **options: Any) -> tuple[int, str, str]:
        """Return the exit code of a command line, its output and its errors."""
        with self.begin(*words, **options) as command:
            out, err = command.communicate(typed, timeout=2 * DEADLINE)
        return command.returncode, out, err

    def verb(self, *words: str) -> tuple[int, str, str]:
        """Run it on ROS 2."""
        return self.run("--engine", "ros2", *words)

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """As a crash: no good-bye on the graph."""
        process.send_signal(signal.SIGKILL)
        process.wait(10)

    def close(self) -> None:
        for process in self._running:
            process.terminate()
        for process in self._running:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                self.kill(process)
            if process.stdin is not None:
                process.stdin.close()


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[Processes]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    # a domain apart from those of the workers' in-process tests, which hear no other process
    running = Processes()
    yield running
    running.close()
