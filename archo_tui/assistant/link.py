"""The one connection to the console that the assistant's process has.

The console knows the assistant by it: when it closes, what was asked is void and the assistant's
goal is cancelled. So it stays open as long as the process lives.
"""

from __future__ import annotations

import asyncio
import itertools
from typing import Any

from archo_tui.remote import finder
from archo_tui.remote.client import Unreached
from archo_tui.remote.protocol import GONE, line, message

SOON = 15.0  # s in which a console that lives answers, STOP included
_LONGEST = 2**24  # bytes of a line of the console
_MOST_UNREAD = 64 * 1024  # bytes that the console has not read: then it is suspended
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
        self._was_connected, self._name = False, ""  # of the socket
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

        It goes to the console that is connected, and as from a shell to every one that could be
        meant where none is: it waits for no connection that another call makes.
        """
        writer, to = self._writer, self._to
        if writer is not None and writer.transport.get_write_buffer_size() > _MOST_UNREAD:
            to = self._name  # it would wait behind what is not read: it gets a connection
        elif writer is not None:
            try:
                return [await self._result(_STOP, SOON)]
            except Unreached:
                if self._writer is not None:  # it was sent, and is not answered
                    raise
        return await asyncio.to_thread(_stop_each, to)

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
                console = await asyncio.to_thread(finder.choose, {"to": self._to})
                self._name = str(console.hello.get("name") or console.hello["pid"])
                connected, rest = console.handed_over()
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


def _stop_each(to: str) -> list[dict[str, Any]]:
    """STOP to each console that could be meant; the answers. Raises Unreached."""
    notices: list[str] = []
    ended = finder.stop({"to": to} if to else {}, notices.append, {"assistant": True})
    answers = [{"code": one.code, "text": one.text} for one in ended]
    answers[0]["text"] = "\n".join((answers[0]["text"], *notices))
    return answers
