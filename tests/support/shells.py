"""`archo-tui VERB` in a thread of the test, beside a console that is reached by its socket."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import AbstractContextManager, asynccontextmanager
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

from archo_tui.cli.options import SUBCOMMANDS
from archo_tui.cli.verb import helps
from archo_tui.client import shell, sockets
from archo_tui.client.connection import Connection
from tests.support import warm
from tests.support.console import AT_ONCE
from tests.support.plain import Typed, operated
from tests.support.waiting import DEADLINE, Waited


class Said(NamedTuple):
    """How a shell's command ended."""

    code: int
    out: str
    err: str


def said(*words: str) -> Said:
    """Run it to its end, here."""
    out, err = io.StringIO(), io.StringIO()
    with patch.object(sys, "stdout", out), patch.object(sys, "stderr", err):
        code = shell.run(words, SUBCOMMANDS, helps=helps)
    return Said(code, out.getvalue(), err.getvalue())


async def typed(*words: str) -> Said:
    """Run it to its end, beside the console that runs on this loop."""
    return await asyncio.to_thread(said, *words)


def client(*words: str) -> subprocess.Popen[str]:
    """Begin it in a process of its own."""
    return subprocess.Popen(
        warm.python("-m", "archo_tui", *words),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {},
    )


class Graph(Connection):
    """Stands for a robot that a verb attaches to where no console acts: what is asked is done."""

    def __init__(self) -> None:
        self.asked: list[list[str]] = []  # The words of each request.

    def attach(self) -> AbstractContextManager[Connection]:
        return contextlib.nullcontext(self)

    def request(self, within: float | None = None, **asked: Any) -> Iterator[dict[str, Any]]:
        self.asked.append(asked["words"])
        yield {"code": "done", "text": "confirmed"}


async def until(holds: Callable[[], object], what: Callable[[], str] = str) -> None:
    """Wait until it holds, whatever goes on beside."""
    waited = Waited(DEADLINE)
    while not holds():
        assert not waited.too_long(), what()
        await asyncio.sleep(0.01)


async def heard(person: Typed, text: str) -> None:
    """Wait until the console says it."""
    await until(lambda: text in person.said, lambda: person.said)


def own_socket() -> str:
    """Return the path of the socket of the console in this process; empty: there is none yet."""
    own = f"{sockets.folder()}/{os.getpid()}-"
    return next((path for path in sockets.socket_paths() if path.startswith(own)), "")


def reached(path: str = "") -> socket.socket:
    """Return a connection to the console of this process, however many wait for one."""
    waited = Waited(DEADLINE)
    while True:
        made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        made.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            made.connect(path or own_socket())
            return made
        made.close()
        assert not waited.too_long()
        time.sleep(0.01)


@asynccontextmanager
async def served(
    *makers: Any, robot: Path | None = None, ros_args: Sequence[str] = (), **options: Any
) -> AsyncIterator[Typed]:
    """A `--plain` that programs reach; its first readings are not waited for."""
    given = {"ros_args": (*AT_ONCE, *ros_args), **options}
    async with operated(*makers, robot=robot, remote=True, **given) as person:
        await until(own_socket, sockets.folder)
        yield person


class Raw:
    """A program that says whatever it likes on the socket."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer

    def send(self, *said: Any) -> None:
        """Requests as JSON, anything else as it is."""
        for one in said:
            data = one if isinstance(one, bytes) else json.dumps(one).encode() + b"\n"
            self.writer.write(data)

    async def line(self) -> dict[str, Any]:
        """The next that is said; empty when the console has closed."""
        try:
            data = await asyncio.wait_for(self.reader.readline(), DEADLINE)
        except OSError:  # what was sent last was not read
            data = b""
        found: dict[str, Any] = json.loads(data) if data else {}
        return found

    async def result(self) -> dict[str, Any]:
        """The next result, whatever is said before."""
        said = await self.line()
        while said and "code" not in said:
            said = await self.line()
        return said

    async def ask(self, *words: str, **more: Any) -> dict[str, Any]:
        """How a request ends."""
        self.send({"id": "ask", "words": [*words], **more})
        return await self.result()

    def close(self) -> None:
        """Leave at once."""
        self.writer.transport.abort()


async def raw() -> Raw:
    """Connected to the console of this process; its hello is not read yet."""
    connected = await asyncio.to_thread(reached)
    return Raw(*await asyncio.open_unix_connection(sock=connected, limit=2**24))


@asynccontextmanager
async def guest() -> AsyncIterator[Raw]:
    """One that has read its hello, and leaves at the end."""
    one = await raw()
    assert (await one.line())["protocol"] == 1
    try:
        yield one
    finally:
        one.close()
