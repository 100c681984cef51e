"""Starts Python programs by a fork of one process that has loaded what archo-tui imports.

A start costs a tenth of a new interpreter's. There is one such process for a run of pytest; the
first test that needs it starts it. What an interpreter reads once and for all when it begins (see
`_READ_ONCE`) must be as it was for the loaded process; else a new interpreter is started.
"""

from __future__ import annotations

import ast
import atexit
import contextlib
import fcntl
import gc
import os
import select
import signal
import socket
import subprocess
import sys
import termios
import threading
import traceback
from pathlib import Path
from typing import NoReturn

_READ_ONCE = ("PYTHON", "TEXTUAL", "LANG", "LC_", "TZ", "AMENT_PREFIX_PATH")
_LOADED = (
    *("archo_tui.screen.app", "archo_tui.session.session", "archo_tui.console.plain"),
    *("archo_tui.user_code.host", "archo_tui.robot.robot"),
    *("archo_tui.screen.terminal.driver", "archo_tui.console.socket", "archo_tui.client.shell"),
    *("archo_tui.client.robot", "archo_tui.client.mcp.server", "archo_tui.recordings.recorder"),
    *("archo_bringup.battery_monitor", "archo_bringup.dashboard", "archo_bringup.motor_controller"),
)
_STREAMS = ("r", "surrogateescape"), ("w", "surrogateescape"), ("w", "backslashreplace")
_MAIN = "import sys\nfrom archo_tui.cli import main\nsys.exit(main(sys.argv[1:]))"
_CLIENT = Path(__file__).with_name("warm_client.py")
ROOT = Path(__file__).parent.parent.parent

_base: dict[str, str] | None = None  # of `_READ_ONCE`, in the loaded process; None: never forked


def allow() -> None:
    """Fork from now on, where tests leave what is read once as it is; called by the whole run."""
    global _base
    os.environ.setdefault("ARCHO_TESTS_RUN", str(os.getpid()))  # the workers inherit it
    _base = _read_once()


def _read_once() -> dict[str, str]:
    return {name: os.environ[name] for name in os.environ if name.startswith(_READ_ONCE)}


def is_usable() -> bool:
    """True where a fork of the loaded process is what a new interpreter would be."""
    return _base is not None and _read_once() == _base


def python(*arguments: str) -> list[str]:
    """Words of a command that does what `python *arguments` does.

    Args:
        arguments: `-m archo_tui WORD ...` or `-c PROGRAM WORD ...`.
    """
    if not is_usable():
        return [sys.executable, *arguments]
    return [sys.executable, "-S", "-I", str(_CLIENT), _server(), *arguments]


def _server() -> str:
    """Return the abstract socket of the run's loaded process; start it if it is not there."""
    name = f"archo-tests-{os.environ['ARCHO_TESTS_RUN']}"
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with open(__file__) as lock, listener:
        fcntl.flock(lock, fcntl.LOCK_EX)  # Between bind and listen nobody can connect.
        try:
            listener.bind("\0" + name)
        except OSError:  # another worker has started it
            return name
        listener.listen(100)
        code = f"from tests.support.warm import serve; serve({listener.fileno()})"
        assert _base is not None
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            pass_fds=[listener.fileno()],
            cwd=ROOT,
            start_new_session=True,
            env={**os.environ, **_base},
        )
        process.returncode = 0  # nobody waits for it: it ends with the run
    return name


class Forked:
    """A process in a terminal, forked from the loaded one; it is killed when this is closed."""

    def __init__(self, slave: int, *arguments: str, environment: dict[str, str], **how: bool):
        """Start `python *arguments`; `how` is what `move_into` takes."""
        self._server = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._server.connect("\0" + _server())
        request = repr(({**os.environ, **environment}, os.getcwd(), arguments, how))
        socket.send_fds(self._server, [request.encode()], [slave])
        self.pid = int(self._server.recv(100))
        self._status: int | None = None

    def status(self) -> int | None:
        """Return what `waitpid` says of the process; None while it runs."""
        if self._status is None and select.select([self._server], [], [], 0)[0]:
            self._status = int(self._server.recv(100))
            self.close()
        return self._status

    def close(self) -> None:
        self._server.close()


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


def serve(descriptor: int) -> None:
    """Fork for each client that connects, and tell it how its process ended."""
    import importlib

    from archo_tui.base.imports import OF_ALL, OF_THE_SCREEN, import_the_rest
    from archo_tui.ros import engine

    run = int(os.environ["ARCHO_TESTS_RUN"])
    engine.activate("embedded")
    for name in _LOADED:
        importlib.import_module(name)
    import_the_rest(("archo_tui.cli", *OF_ALL, *OF_THE_SCREEN))
    gc.collect()
    gc.freeze()
    listener = socket.socket(fileno=descriptor)
    woken, wakes = os.pipe()
    os.set_blocking(wakes, False)
    signal.set_wakeup_fd(wakes)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    clients: dict[int, socket.socket] = {}  # by process

    while _is_alive(run):
        watched: list[socket.socket | int] = [listener, woken, *clients.values()]
        ready, _, _ = select.select(watched, [], [], 1.0)
        for pid, client in [*clients.items()]:
            if client in ready:  # it has gone
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
                clients.pop(pid).close()
        if woken in ready:
            os.read(woken, 1000)
        with contextlib.suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                if ended[0] in clients:
                    with contextlib.suppress(OSError):
                        clients[ended[0]].send(str(ended[1]).encode())
                    clients.pop(ended[0]).close()
        if listener in ready:
            client, _ = listener.accept()
            request, streams, _, _ = socket.recv_fds(client, 1_000_000, 3)
            if not request:
                client.close()
                continue
            pid = os.fork()
            if pid == 0:
                signal.set_wakeup_fd(-1)
                _become(streams, *ast.literal_eval(request.decode()))
            for stream in streams:
                os.close(stream)
            clients[pid] = client
            with contextlib.suppress(OSError):
                client.send(str(pid).encode())


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def _become(
    streams: list[int],
    environment: dict[str, str],
    folder: str,
    arguments: list[str],
    terminal: dict[str, bool] | None,
) -> NoReturn:
    """Be `python *arguments` with those streams; `streams` is one terminal's, or all three."""
    status = 1
    try:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if terminal is not None:
            move_into(streams[0], **terminal)
        else:
            for number, stream in enumerate(streams):
                os.dup2(stream, number)
            os.closerange(3, 1000)
        atexit._clear()
        os.environ.clear()
        os.environ |= environment
        os.chdir(folder)
        kind, program, *words = arguments
        sys.argv = ["-c" if kind == "-c" else program, *words]
        sys.stdin, sys.stdout, sys.stderr = sys.__stdin__, sys.__stdout__, sys.__stderr__ = [  # type: ignore
            open(n, mode, _buffering(n), "utf-8", errors, closefd=False)  # noqa: SIM115
            for n, (mode, errors) in enumerate(_STREAMS)
        ]
        exec(program if kind == "-c" else _MAIN, {"__name__": "__main__"})
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            sys.stderr.write(f"{end.code}\n")
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(_ended(status))


def _buffering(descriptor: int) -> int:
    """Return what an interpreter chooses: lines for a terminal and for errors."""
    return 1 if descriptor == 2 or os.isatty(descriptor) else -1


def _ended(status: int) -> int:
    """Do what an interpreter does as it ends; returns the exit code."""
    with contextlib.suppress(Exception):
        threading._shutdown()  # type: ignore[attr-defined]  # joins threads
    with contextlib.suppress(Exception):
        atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
    except Exception:
        return 120
    return status
