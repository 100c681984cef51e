"""An assistant's client over stdio, and a console that says what the test wants."""

from __future__ import annotations

import asyncio
import json
import os
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Any, NamedTuple

from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client

from archo_tui.client import sockets
from archo_tui.console import socket as server
from tests.support import warm
from tests.support.waiting import DEADLINE

Request = dict[str, Any]
GOALS = [{"kind": "go", "title": "Go to shelf", "values": {"shelf_number": {"type": "int32"}}}]


class Said(NamedTuple):
    """What a tool answered."""

    failed: bool
    data: dict[str, Any]

    @property
    def robot(self) -> Any:
        """What the robot said."""
        return self.data["from_the_robot"]


class Assistant:
    """A client of the protocol, and the process that it has started."""

    def __init__(self, client: Client) -> None:
        self.client = client

    async def call(self, name: str, /, **given: Any) -> Said:
        """Call a tool; what it says as text and as data is the same."""
        result = await asyncio.wait_for(self.client.call_tool(name, given), DEADLINE)
        (content,) = result.content
        data: dict[str, Any] = result.structured_content
        assert json.loads(content.text) == data  # type: ignore[union-attr]
        return Said(result.is_error, data)

    async def tools(self) -> dict[str, Any]:
        """All tools by name."""
        listed = await asyncio.wait_for(self.client.list_tools(), DEADLINE)
        return {tool.name: tool for tool in listed.tools}


def parameters(*words: str, code: str = "") -> StdioServerParameters:
    """How a client starts it; `code` is Python that runs before."""
    words = ("mcp", *words)
    program = f"import sys\n{code}\nfrom archo_tui.cli import main\nsys.exit(main({words!r}))"
    given = {
        name: os.environ[name]
        for name in os.environ
        if name.startswith(("XDG_", "PYTHON", "ARCHO"))
    }
    command, *arguments = warm.python("-c", program)
    return StdioServerParameters(command=command, args=arguments, env=given)


INITIALIZE = (
    b'{"jsonrpc": "2.0", "id": 0, "method": "initialize", "params": {"protocolVersion": '
    b'"2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "0"}}}\n'
    b'{"jsonrpc": "2.0", "method": "notifications/initialized"}\n'
)


async def process(*words: str, first: bytes = b"") -> asyncio.subprocess.Process:
    """Its process, to which that was written."""
    given = parameters(*words)
    made = await asyncio.create_subprocess_exec(
        given.command, *given.args, env=given.env, stdin=-1, stdout=-1, stderr=-1
    )
    assert made.stdin is not None
    made.stdin.write(first)
    return made


@asynccontextmanager
async def assistant(*words: str, **more: Any) -> AsyncIterator[Assistant]:
    """One that runs, `--allow goals` among its words or not."""
    async with Client(stdio_client(parameters(*words, **more))) as client:
        yield Assistant(client)


class FakeConsole:
    """Speaks the protocol on a socket, answers by `answers`, and keeps what it was asked."""

    def __init__(self, hello: dict[str, Any]) -> None:
        self.hello = hello
        self.asked: list[Request] = []
        self.connections = self.closed = 0
        self.answers: dict[str, Callable[[Request], Awaitable[Request | None]]] = {}
        self.answer("goals", "done", data=GOALS)
        self._clients: list[socket.socket] = []

    def answer(self, word: str, code: str, text: str = "", **more: Any) -> None:
        """Always answer so to requests that begin with this word."""

        async def same(_: Request) -> Request:
            return {"code": code, "text": text, **more}

        self.answers[word] = same

    async def serve(self, listening: socket.socket) -> None:
        """Take connections until cancelled; what a client has sent is read though it has left."""
        loop, tasks = asyncio.get_running_loop(), []

        def accept() -> None:
            with suppress(BlockingIOError):  # It has left.
                client, _ = listening.accept()
                client.setblocking(False)
                self.connections += 1
                self._clients.append(client)
                tasks.append(asyncio.ensure_future(self._serve(client)))

        listening.setblocking(False)
        loop.add_reader(listening, accept)  # A cancelled sock_accept may lose a connection.
        try:
            await loop.create_future()
        finally:
            loop.remove_reader(listening)
            for client in self._clients:  # As a console that ends does.
                with suppress(OSError):
                    client.shutdown(socket.SHUT_RDWR)
            await asyncio.gather(*tasks)

    async def _serve(self, client: socket.socket) -> None:
        self._say(client, self.hello)
        loop, tasks, data = asyncio.get_running_loop(), [], b""
        while True:
            with suppress(ConnectionError):  # Told once; then comes what the client had sent.
                if not (part := await loop.sock_recv(client, 65536)):
                    break
                *lines, data = (data + part).split(b"\n")
                for request in map(json.loads, lines):
                    word = self._note(request)
                    tasks.append(asyncio.ensure_future(self._answer(word, request, client)))
        self.closed += 1
        for task in tasks:
            task.cancel()
        self._clients.remove(client)
        client.close()

    def _note(self, request: Request) -> str:
        """Keep a request, and return its first word."""
        word: str = request["words"][0] if "words" in request else "ask"
        self.asked.append(request)
        return word

    async def _answer(self, word: str, request: Request, client: socket.socket) -> None:
        said = await self.answers[word](request) if word in self.answers else None
        if said is not None:
            self._say(client, {"id": request["id"], **said})

    def _say(self, client: socket.socket, said: Any) -> None:
        with suppress(OSError):  # It has left.
            client.sendall(json.dumps(said).encode() + b"\n")

    def say(self, said: Any) -> None:
        """Say this to everybody."""
        self.write(json.dumps(said).encode() + b"\n")

    def write(self, data: bytes) -> None:
        """The same, and it need not be JSON."""
        for client in self._clients:
            client.sendall(data)

    def drop(self) -> None:
        """Close every connection, as a console that ends does."""
        for client in self._clients:
            client.shutdown(socket.SHUT_RDWR)

    def words(self) -> list[Any]:
        """What it was asked, without numbers."""
        return [request.get("words", request.get("ask")) for request in self.asked]


HELLO = {"protocol": 1, "version": "0", "robot": "ARCHO", "engine": "embedded", "domain": None}


@contextmanager
def listening(
    namespace: str, pid: int = 7, **more: Any
) -> Iterator[tuple[socket.socket, dict[str, Any]]]:
    """Listen where a console does, and take nobody: as one that is suspended."""
    name = f"{pid}-{os.urandom(4).hex()}"
    hello = {**HELLO, "namespace": namespace, "pid": pid, "watching": False, "name": name, **more}
    made, path = server.open_socket(hello)
    try:
        yield made, hello
    finally:
        made.close()
        sockets.remove(path)


@asynccontextmanager
async def fake_console(
    pid: int = 7, namespace: str = "", **more: Any
) -> AsyncIterator[FakeConsole]:
    """One that listens where consoles do, and answers."""
    with listening(namespace or f"/r{pid}", pid, **more) as (made, hello):
        console = FakeConsole(hello)
        serving = asyncio.ensure_future(console.serve(made))
        try:
            yield console
        finally:
            serving.cancel()
            with suppress(asyncio.CancelledError):
                await serving
