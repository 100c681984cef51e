"""Starts archo-tui by a fork of a process that has loaded it: a third of what a start costs.

For tests that look at what comes after the start. What a process reads once and for all when it
begins (its environment, but for the folders of a test) must be the same; else it is begun anew.
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import json
import os
import select
import signal
import socket
import subprocess
import sys
import termios
import threading
import traceback
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

_FOLDERS = {"XDG_CONFIG_HOME", "XDG_STATE_HOME"}  # read whenever a file is looked for
_OTHERS = {"TERM", "ROS_DOMAIN_ID", "PYTEST_CURRENT_TEST", "PWD", "OLDPWD"}
_LOADED = (
    *(
        "archo_tui.app",
        "archo_tui.session",
        "archo_tui.hosting.host",
        "archo_tui.hosting.node_files",
    ),
    *("archo_tui.robot.client", "archo_tui.terminal.driver"),
    *("archo_bringup.battery_monitor", "archo_bringup.dashboard", "archo_bringup.motor_controller"),
)


ROOT = Path(__file__).parent.parent.parent

is_on = False  # in the tests; a measurement is of a new interpreter


@cache
def _of(environment: frozenset[tuple[str, str]]) -> Warm:
    made = Warm()
    atexit.register(made.close)
    return made


def loaded() -> Warm | None:
    """The process that began with the environment that is set now; None: begin anew."""
    passing = _FOLDERS | _OTHERS
    environment = frozenset((k, v) for k, v in os.environ.items() if k not in passing)
    return _of(environment) if is_on else None


def move_into(slave: int, *, controlling: bool, ignore_hangup: bool) -> None:
    """Leave this process's terminal for that one, and all files."""
    if ignore_hangup:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    os.setsid()
    if controlling:
        fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
    for number in (0, 1, 2):
        os.dup2(slave, number)
    os.closerange(3, 100)


class Warm:
    """The process that is forked."""

    def __init__(self) -> None:
        self._socket, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        code = f"from tests.support.warm import serve; serve({other.fileno()})"
        words = [sys.executable, "-c", code]
        self._server = subprocess.Popen(words, pass_fds=[other.fileno()], cwd=ROOT)
        other.close()
        self._ended: dict[int, int] = {}  # statuses by process

    def start(self, slave: int, **what: Any) -> int:
        """Run archo-tui in a terminal: the number of its process."""
        request = json.dumps({**what, "environment": dict(os.environ) | what["environment"]})
        socket.send_fds(self._socket, [request.encode()], [slave])
        while (said := self._heard())["kind"] != "started":
            pass
        return int(said["pid"])

    def status(self, pid: int) -> int | None:
        """What `waitpid` says of a process; None while it runs."""
        self._socket.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                self._heard()
        self._socket.setblocking(True)
        return self._ended.get(pid)

    def close(self) -> None:
        self._socket.close()
        self._server.wait()

    def _heard(self) -> dict[str, Any]:
        said: dict[str, Any] = json.loads(self._socket.recv(1000))
        if said["kind"] == "ended":
            self._ended[said["pid"]] = said["status"]
        return said


def serve(descriptor: int) -> None:
    """Fork whenever it is asked for, and say how each process ended."""
    import importlib

    from archo_tui import engine

    engine.activate("embedded")
    for name in _LOADED:
        importlib.import_module(name)
    channel = socket.socket(fileno=descriptor)
    woken, wakes = os.pipe()
    os.set_blocking(wakes, False)
    signal.set_wakeup_fd(wakes)
    signal.signal(signal.SIGCHLD, lambda *_: None)

    while True:
        ready, _, _ = select.select([channel.fileno(), woken], [], [])
        if woken in ready:
            os.read(woken, 1000)
            with contextlib.suppress(ChildProcessError):
                while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                    said = {"kind": "ended", "pid": ended[0], "status": ended[1]}
                    channel.send(json.dumps(said).encode())
        if channel.fileno() in ready:
            request, slaves, _, _ = socket.recv_fds(channel, 1_000_000, 1)
            if not request:
                return
            pid = os.fork()
            if pid == 0:
                signal.set_wakeup_fd(-1)
                _become(slaves[0], **json.loads(request))
            os.close(slaves[0])
            channel.send(json.dumps({"kind": "started", "pid": pid}).encode())


def _become(
    slave: int,
    environment: dict[str, str],
    folder: str,
    arguments: list[str],
    code: str,
    controlling: bool,
    ignore_hangup: bool,
) -> NoReturn:
    """Be archo-tui in that terminal."""
    status = 1
    try:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        move_into(slave, controlling=controlling, ignore_hangup=ignore_hangup)
        os.environ.clear()
        os.environ |= environment
        os.chdir(folder)
        streams = [os.fdopen(number, mode, 1, closefd=False) for number, mode in enumerate("rww")]
        sys.stdin, sys.stdout, sys.stderr = streams
        sys.__stdin__, sys.__stdout__, sys.__stderr__ = streams  # type: ignore
        exec(f"import sys\n{code}", {"__name__": "__main__"})
        from archo_tui.cli import main

        status = main(arguments)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            threading._shutdown()  # type: ignore[attr-defined]  # as the interpreter does: joins
        with contextlib.suppress(Exception):
            sys.stdout.flush()
        os._exit(status)
