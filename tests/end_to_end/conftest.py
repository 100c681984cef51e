"""A tmux server and an sshd of the tests' own, on loopback."""

from __future__ import annotations

import getpass
import os
import shlex
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.waiting import wait_until

COMMAND = [sys.executable, "-m", "archo_tui"]


class Tmux:
    """A person at a terminal of tmux."""

    def __init__(self, folder: Path) -> None:
        self._socket = str(folder / "tmux")

    def _run(self, *words: str) -> str:
        command = ["tmux", "-f", "/dev/null", "-S", self._socket, *words]
        environ = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES")}
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environ)
        return done.stdout

    def start(self, command: str, size: tuple[int, int] = (120, 36)) -> None:
        width, height = map(str, size)
        line = f"{command}; echo ENDED $?; sleep 1000"
        self._run("new-session", "-d", "-x", width, "-y", height, "-s", "it", "sh", "-c", line)

    def type(self, *keys: str) -> None:
        self._run("send-keys", "-t", "it", *keys)

    @property
    def screen(self) -> str:
        return self._run("capture-pane", "-p", "-t", "it")

    def until(self, text: str, deadline: float = 30.0) -> None:
        end = time.monotonic() + deadline
        while text not in self.screen:
            assert time.monotonic() < end, f"waited for {text!r}:\n{self.screen}"
            time.sleep(0.05)

    def close(self) -> None:
        subprocess.run(["tmux", "-S", self._socket, "kill-server"], check=False)


@pytest.fixture
def tmux(tmp_path: Path) -> Iterator[Tmux]:
    assert shutil.which("tmux"), "install tmux"
    made = Tmux(tmp_path)
    yield made
    made.close()


class Sshd:
    """A real sshd, with a key of its own."""

    def __init__(self, folder: Path) -> None:
        for name in ("host", "user"):
            command = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / name)]
            subprocess.run(command, check=True)
        shutil.copy(folder / "user.pub", folder / "authorized")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        config = folder / "sshd_config"
        config.write_text(
            f"Port {self.port}\nListenAddress 127.0.0.1\nHostKey {folder / 'host'}\n"
            f"AuthorizedKeysFile {folder / 'authorized'}\nPidFile {folder / 'pid'}\n"
            "StrictModes no\nUsePAM no\nPasswordAuthentication no\nPermitRootLogin yes\n"
            "AcceptEnv XDG_* ARCHO_*\n"
        )
        Path("/run/sshd").mkdir(parents=True, exist_ok=True)  # where sshd gives up its privileges
        sshd = shutil.which("sshd") or "/usr/sbin/sshd"
        log = str(folder / "sshd.log")
        self._server = subprocess.Popen([sshd, "-D", "-f", str(config), "-E", log])
        self._key = folder / "user"
        wait_until(self._listens, "sshd")

    def _listens(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def command(self, remote: str) -> str:
        """The shell's line that runs a command over there in a terminal."""
        options = (
            "-tt -o StrictHostKeyChecking=no -o UserKnownHostsFile=/dev/null -o LogLevel=QUIET"
        )
        where = f"{getpass.getuser()}@127.0.0.1"
        names = ("XDG_CONFIG_HOME", "XDG_STATE_HOME")
        variables = " ".join(f"{name}={shlex.quote(os.environ[name])}" for name in names)
        line = shlex.quote(f"cd {shlex.quote(str(Path.cwd()))} && env {variables} {remote}")
        return f"ssh {options} -i {self._key} -p {self.port} {where} {line}"

    def connections(self) -> list[int]:
        """The processes of sshd that serve a connection."""
        found = subprocess.run(
            ["pgrep", "-P", str(self._server.pid)], capture_output=True, text=True, check=False
        )
        return [int(pid) for pid in found.stdout.split()]

    def close(self) -> None:
        self._server.terminate()
        self._server.wait(10)


@pytest.fixture
def sshd(tmp_path: Path) -> Iterator[Sshd]:
    server = Sshd(tmp_path)
    yield server
    server.close()
