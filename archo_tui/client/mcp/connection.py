"""The connection of the assistant's process to the console.

The console knows the assistant by its connection: when it closes, every approval request of the
assistant is void and its goal is cancelled. So it stays open as long as the process lives.
"""

from __future__ import annotations

import asyncio
import itertools
from typing import Any

from archo_tui.client import find
from archo_tui.client.connection import Unreached
from archo_tui.client.protocol import GONE, decode, encode

ANSWER_TIMEOUT = 15.0  # Seconds in which a live console answers anything, STOP included.
_MAX_LINE = 2**24  # Bytes.
_MAX_UNREAD = 64 * 1024  # Bytes; a console that leaves more unread is suspended.
_STOP = {"assistant": True, "words": ["stop"]}
SILENT = "the console does not answer: is it suspended? The robot may still be moving"
CONSOLE_CHANGED = (
    "The console was restarted, or is another one now. What was asked for before is void: look at "
    "`status` before anything else."
)


class ConsoleConnection:
    """The assistant's connection to a console, which each request opens if needed."""

    def __init__(self, to: str) -> None:
        self._to = to  # "": that which ARCHO_TUI_CONSOLE names, or else the only one.
        self._request_lock, self._connect_lock = asyncio.Lock(), asyncio.Lock()
        self._writer: asyncio.StreamWriter | None = None
        self._reading: asyncio.Task[None] | None = None
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._was_connected, self._name = False, ""  # The name of the console's socket.
        self._notice = ""

    def take_notice(self) -> str:
        """Return and clear the notice of a restarted console, or of another one; "" for none."""
        notice, self._notice = self._notice, ""
        return notice

    async def request(
        self, answer_timeout: float = ANSWER_TIMEOUT, **fields: Any
    ) -> dict[str, Any]:
        """Send a request after those before it, and return its result, or raise Unreached."""
        async with self._request_lock:
            return await self._send_and_wait(fields, answer_timeout)

    async def stop(self) -> list[dict[str, Any]]:
        """Send STOP at once, whatever else waits, and return the consoles' results.

        Without a connection, or if it breaks before the result, STOP goes to every console that
        could be meant. A code other than `done` means not confirmed. Raises Unreached.
        """
        writer, to = self._writer, self._to
        if writer is not None and writer.transport.get_write_buffer_size() > _MAX_UNREAD:
            to = self._name  # A connection of its own does not wait behind unread data.
        elif writer is not None:
            try:
                return [await self._send_and_wait(_STOP, ANSWER_TIMEOUT)]
            except Unreached:
                if self._writer is not None:  # It was sent, and got no answer.
                    raise
        return await asyncio.to_thread(_stop_each, to)

    async def close(self) -> None:
        """Close the connection; requests without a result raise Unreached."""
        if self._writer is not None:
            self._writer.transport.abort()
        if self._reading is not None:
            await self._reading

    async def _send_and_wait(self, fields: dict[str, Any], answer_timeout: float) -> dict[str, Any]:
        writer = await self._connect()
        if writer.transport.get_write_buffer_size() > _MAX_UNREAD:
            raise Unreached(SILENT)
        number = next(self._numbers)
        answer = asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        try:
            writer.write(encode({"id": number, "assistant": True, **fields}))
            return await asyncio.wait_for(answer, answer_timeout)
        except asyncio.TimeoutError:
            raise Unreached(SILENT) from None
        finally:
            self._waiting.pop(number, None)

    async def _connect(self) -> asyncio.StreamWriter:
        async with self._connect_lock:  # Concurrent calls share one connection.
            if self._writer is None:
                console = await asyncio.to_thread(find.choose, {"to": self._to})
                self._name = console.card["name"]
                console.socket.setblocking(False)
                reader, self._writer = await asyncio.open_connection(
                    sock=console.socket, limit=_MAX_LINE
                )
                self._notice = CONSOLE_CHANGED if self._was_connected else ""
                self._was_connected = True
                self._reading = asyncio.create_task(
                    self._read(reader, self._writer, console._buffer)
                )
            return self._writer

    async def _read(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, rest: bytes
    ) -> None:
        """Deliver each result to the request that waits for it, until the console is gone.

        Then every waiting request raises Unreached. `rest` was read from the socket before.
        """
        try:
            while data := await reader.readline():
                self._deliver(decode(rest + data))
                rest = b""
        except (OSError, ValueError):  # Invalid data is treated like a closed connection.
            pass
        finally:
            self._writer = None
            writer.transport.abort()
            for answer in self._waiting.values():
                if not answer.done():
                    answer.set_exception(Unreached(GONE))

    def _deliver(self, reply: dict[str, Any]) -> None:
        number = reply.get("id")
        answer = self._waiting.get(number) if isinstance(number, int) else None
        if answer is not None and not answer.done() and isinstance(reply.get("code"), str):
            answer.set_result(reply)


def _stop_each(to: str) -> list[dict[str, Any]]:
    """Send STOP to each console that could be meant, wait up to 15 s, and return their results."""
    notices: list[str] = []
    ended = find.stop({"to": to} if to else {}, notices.append, {"assistant": True})
    answers = [{"code": answer.code, "text": answer.text} for answer in ended]
    answers[0]["text"] = "\n".join((answers[0]["text"], *notices))
    return answers
