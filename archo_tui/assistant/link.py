"""The one connection to the console that the assistant's process has.

The console knows the assistant by it: when it closes, what was asked is void and the assistant's
goal is cancelled. So it stays open as long as the process lives.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import os
from collections.abc import Iterator
from typing import Any

from archo_tui.remote import place
from archo_tui.remote.client import Connection, Unreached, chosen, one
from archo_tui.remote.protocol import GONE, line, message

SOON = 15.0  # s in which a console that lives answers, STOP included
_LONGEST = 2**24  # bytes of a line of the console
_MOST_UNREAD = 64 * 1024  # bytes that the console has not read: then it is suspended
_RUNTIME = "/run/user"  # where Linux has a folder for each user who is logged in
_STOP = {"assistant": True, "words": ["stop"]}
SILENT = "the console does not answer: is it suspended? The robot may still be moving"
RESTARTED = (
    "The console was restarted, or is another one now. What was asked for before is void: look at "
    "`status` before anything else."
)


class Link:
    """Connects when it is needed, and again when the console was restarted."""

    def __init__(self, to: str) -> None:
        """`to` is a process or namespace among several consoles, empty: the only one."""
        self._to = to
        self._turn, self._connecting = asyncio.Lock(), asyncio.Lock()
        self._writer: asyncio.StreamWriter | None = None
        self._reading: asyncio.Task[None] | None = None
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._was_connected = False
        self._news = ""

    def take_news(self) -> str:
        """What happened to the connection since this was asked last; empty: nothing."""
        news, self._news = self._news, ""
        return news

    async def ask(self, within: float = SOON, **asked: Any) -> dict[str, Any]:
        """The result of a request, when those before it have theirs. Raises Unreached.

        `within` is how long an answer may take, in s.
        """
        async with self._turn:
            return await self._result(asked, within)

    async def stop(self) -> list[dict[str, Any]]:
        """STOP, at once, whatever else waits; the answers. Raises Unreached.

        As from a shell it goes to every console that may be meant, where several are.
        """
        try:
            return [await self._result(_STOP, SOON)]
        except Unreached:
            if self._writer is not None:  # it was sent, and is not answered
                raise
        return await asyncio.to_thread(_stop_each, self._to)

    async def close(self) -> None:
        """Leave."""
        if self._writer is not None:
            self._writer.transport.abort()
        if self._reading is not None:
            await self._reading

    async def _result(self, asked: dict[str, Any], within: float) -> dict[str, Any]:
        writer = await self._connected()
        if writer.transport.get_write_buffer_size() > _MOST_UNREAD:
            raise Unreached(SILENT)
        number = next(self._numbers)
        answer = asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        try:
            writer.write(line({"id": number, "assistant": True, **asked}))
            return await asyncio.wait_for(answer, within)
        except asyncio.TimeoutError:
            raise Unreached(SILENT) from None
        finally:
            self._waiting.pop(number, None)

    async def _connected(self) -> asyncio.StreamWriter:
        async with self._connecting:  # two calls make one connection
            if self._writer is None:
                connected, rest = (await asyncio.to_thread(_found, self._to)).handed_over()
                connected.setblocking(False)
                reader, self._writer = await asyncio.open_connection(sock=connected, limit=_LONGEST)
                self._news = RESTARTED if self._was_connected else ""
                self._was_connected = True
                self._reading = asyncio.create_task(self._read(reader, self._writer, rest))
            return self._writer

    async def _read(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, rest: bytes
    ) -> None:
        """Hand each result to whoever waits for it, until the console goes."""
        try:
            while data := await reader.readline():
                self._hand_on(message(rest + data))
                rest = b""
        except (OSError, ValueError):  # as if it had gone: what it says is no protocol
            pass
        finally:
            self._writer = None
            writer.transport.abort()
            for answer in self._waiting.values():
                if not answer.done():
                    answer.set_exception(Unreached(GONE))

    def _hand_on(self, said: dict[str, Any]) -> None:
        number = said.get("id")
        answer = self._waiting.get(number) if isinstance(number, int) else None
        if answer is not None and not answer.done() and isinstance(said.get("code"), str):
            answer.set_result(said)


def _found(to: str) -> Connection:
    """The console that is meant. Raises Unreached."""
    with _where_consoles_are():
        return one(to)


def _stop_each(to: str) -> list[dict[str, Any]]:
    """STOP to each console that fits, before any is waited for. Raises Unreached."""
    answers = []
    with _where_consoles_are():
        consoles = chosen(to)
    for console in consoles:
        with contextlib.suppress(Unreached):  # said when its answer is read
            console.send({"id": 1, **_STOP})
    for console in consoles:
        try:
            answers.append(next(said for said in console.rest(SOON) if "code" in said))
        except Unreached as error:
            answers.append({"code": "lost", "text": str(error)})
        finally:
            console.close()
    return answers


@contextlib.contextmanager
def _where_consoles_are() -> Iterator[None]:
    """MCP clients pass few variables on, and XDG_RUNTIME_DIR is not among them.

    Without it the consoles of a desktop are looked for in the folder that it names on Linux.
    """
    usual = os.path.join(_RUNTIME, str(os.getuid())) if hasattr(os, "getuid") else ""
    if os.environ.get("XDG_RUNTIME_DIR") or place.sockets() or not os.path.isdir(usual):
        yield
        return
    os.environ["XDG_RUNTIME_DIR"] = usual
    try:
        yield
    finally:
        del os.environ["XDG_RUNTIME_DIR"]
