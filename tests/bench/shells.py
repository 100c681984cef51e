"""Other programs beside the console: `python -m tests.bench.shells`.

Prints how long STOP takes to the node's callback, in ms, of a shell and by ctrl+x on the screen,
while no program, one, then four send 10,000 requests a second and telemetry comes at 50 Hz; and the
CPU of `archo-tui status --line` beside `python -c pass`: the design asks for 3 times at most.
"""

from __future__ import annotations

import asyncio
import os
import resource
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from archo_tui import engine

engine.activate("embedded", hosting=True)

from archo_bringup.battery_monitor import BatteryMonitor  # noqa: E402
from archo_bringup.motor_controller import MotorController  # noqa: E402

from archo_tui.app import ArchoApp  # noqa: E402
from archo_tui.client import sockets  # noqa: E402
from archo_tui.keyed_app import HELD  # noqa: E402
from archo_tui.session import Session  # noqa: E402
from archo_tui.session_options import Options  # noqa: E402
from tests.support.console import send  # noqa: E402
from tests.support.shells import reached  # noqa: E402

_STOPS = 25
_RATE = 10_000  # requests a second of one program
_RUNS = 15
_FLOOD = """\
import json, os, socket, sys, time
folder, name = os.path.split(sys.argv[1])
os.chdir(folder)
console = socket.socket(socket.AF_UNIX)
console.connect(name)
console.setblocking(False)
request = json.dumps({"id": 1, "words": ["status"]}).encode() + b"\\n"
rest = b""
while True:
    rest = rest or request * (int(sys.argv[2]) // 100)
    try:
        rest = rest[console.send(rest):]
        console.recv(1 << 20)
    except BlockingIOError:
        pass
    time.sleep(0.01)
"""


class Stopped(MotorController):
    """The motor's node, which notes when it is told to stop."""

    heard: list[float] = []

    def emergency_stop(self, request: Any, response: Any) -> Any:
        self.heard.append(time.perf_counter())
        return super().emergency_stop(request, response)


def _stop(path: str) -> float:
    """When a STOP of a program of its own connection was sent."""
    connected = reached(path)
    connected.settimeout(1.0)
    begin = time.perf_counter()
    connected.sendall(b'{"id": 1, "words": ["stop"]}\n')
    threading.Timer(1.0, connected.close).start()
    return begin


async def _heard(number: int) -> float:
    while len(Stopped.heard) <= number:
        await asyncio.sleep(0.001)
    return Stopped.heard[number]


async def _measure(app: ArchoApp, path: str) -> tuple[list[float], list[float]]:
    shell, keys = [], []
    for _ in range(_STOPS):
        number = len(Stopped.heard)
        begin = await asyncio.to_thread(_stop, path)
        shell.append(1000 * (await _heard(number) - begin))
        await asyncio.sleep(HELD + 0.1)
        number, begin = len(Stopped.heard), time.perf_counter()
        send(app, "ctrl+x")
        keys.append(1000 * (await _heard(number) - begin))
        await asyncio.sleep(HELD + 0.1)
    return shell, keys


async def _floods(session: Session) -> None:
    app = ArchoApp(session.station)
    async with app.run_test(size=(120, 36)):
        while len(app.view.snapshot.offered) < 4 or not sockets.socket_paths():
            await asyncio.sleep(0.1)
        (path,) = sockets.socket_paths()
        for programs in (0, 1, 4):
            command = [sys.executable, "-c", _FLOOD, path, str(_RATE)]
            floods = [subprocess.Popen(command) for _ in range(programs)]
            await asyncio.sleep(1.0)
            busy = time.process_time()
            begin = time.perf_counter()
            shell, keys = await _measure(app, path)
            busy = (time.process_time() - busy) / (time.perf_counter() - begin)
            for flood in floods:
                flood.kill()
                flood.wait()
            for name, took in (("a shell", shell), ("ctrl+x", keys)):
                median, worst = statistics.median(took), max(took)
                print(f"{programs} floods, STOP of {name}: median {median:.1f}, worst {worst:.1f}")
            print(f"{programs} floods: {100 * busy:.0f} % of a core")


def _cpu(*command: str) -> float:
    """s of the processor that it takes, the least of several runs."""
    took = []
    for _ in range(_RUNS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        took.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return statistics.median(took)


def main() -> None:
    """Run and print."""
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # as it is installed
    with TemporaryDirectory() as folder:
        os.environ[sockets.FOLDER_VARIABLE] = folder
        fast = ("-p", "publish_period:=0.02")
        makers = (Stopped, BatteryMonitor)
        options = Options(node_makers=makers, remote=True, ros_args=fast)
        with Session(options) as session:
            asyncio.run(_floods(session))
        plain = [sys.executable, "-m", "archo_tui", "--plain"]
        with subprocess.Popen(plain, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL) as console:
            while not sockets.socket_paths():
                time.sleep(0.1)
            script = str(Path(sys.executable).with_name("archo-tui"))
            nothing = _cpu(sys.executable, "-c", "pass")
            line = _cpu(script, "status", "--line")
            console.kill()
        print(f"status --line: {line / nothing:.2f} times `python -c pass`")


if __name__ == "__main__":
    main()
