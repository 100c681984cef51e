"""The console's socket: takes what programs of the same user send, on a thread of its own.

Requests of one client are carried out one after the other; STOP is read ahead of them, counted as
it is read, and waits for nothing. Whoever floods or does not read delays nobody else.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import struct
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import cached_property
from itertools import islice
from typing import Any, Protocol

from archo_tui.plain.lines import TOO_LONG, LineCutter
from archo_tui.remote import place
from archo_tui.remote.protocol import is_stop, line, message
from archo_tui.robot.stops import Stops

MOST_CLIENTS = 16  # a further one may send STOP and nothing else
MOST_OPEN = 64  # of these further ones the oldest goes for the next
MOST_WAITING = 256 * 1024  # bytes of requests of one client that wait
MOST_UNREAD = 256 * 1024  # bytes that a client has not read; then it is dropped
APART = 0.02  # s between two requests of one client
_CHUNK = 64 * 1024
_REST = 0.004  # s between two pieces of all clients: who floods leaves time for the screen
_LONGEST_ID = 100  # characters


class Guest(Protocol):
    """Who is served, as the desk sees it."""

    pid: int  # 0: not known

    def tell(self, said: dict[str, Any]) -> None:
        """Say something to it, from any thread."""

    def done(self) -> None:
        """What it asked for has ended."""


class Desk(Protocol):
    """What carries out what is sent; its methods are called on the server's thread."""

    def hello(self) -> dict[str, Any]:
        """What every client is told first."""

    def serve(self, client: Guest, request: dict[str, Any], stops: int) -> None:
        """Begin to carry it out; `client.done()` is called when that has ended."""

    def answer(self, client: Guest, answer: dict[str, Any], stops: int) -> None:
        """What a client says while its request is carried out."""

    def gone(self, client: Guest) -> None:
        """It has left."""


class Client:
    """One program that is connected."""

    def __init__(self, server: Server, writer: asyncio.StreamWriter, pid: int) -> None:
        self.pid = pid
        self._server, self._writer = server, writer
        self._loop = asyncio.get_running_loop()
        self._waiting: deque[tuple[bytes, int]] = deque()
        self._size = 0  # bytes of them
        self._is_busy = self._rests = self._overflows = False

    # from any thread

    def tell(self, said: dict[str, Any]) -> None:
        """Send a message; a client that does not read is dropped."""
        with contextlib.suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._write, line(said))

    def done(self) -> None:
        """What it asked for has ended: the next may come."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._rest)

    # on the server's thread

    def _write(self, data: bytes) -> None:
        transport = self._writer.transport
        if transport.is_closing():
            return
        if transport.get_write_buffer_size() > MOST_UNREAD:
            transport.abort()
            return
        self._writer.write(data)

    def take(self, data: bytes) -> None:
        """One line that it sent."""
        stops = self._server.stops
        if data == TOO_LONG:
            self.refuse(None, "misuse", "a line of more than 64 kB")
            return
        request = _read(data) if b"stop" in data.lower() else None
        if request is not None and is_stop(request):
            self._server.desk.serve(self, request, stops.read())
        elif not self._server.takes_all_of(self):
            self.refuse(
                data, "refused", f"{MOST_CLIENTS} clients are connected: only stop is taken"
            )
        elif self._is_busy and _is_answer(data) and not (self._rests and self._waiting):
            self._server.desk.answer(self, _read(data) or {}, stops.count)
        elif self._size + len(data) > MOST_WAITING:
            if not self._overflows:
                self.refuse(data, "refused", "too many requests wait")
            self._overflows = True
        else:
            self._waiting.append((data, stops.count))
            self._size += len(data)
            if not self._is_busy:
                self._next()

    def _rest(self) -> None:
        self._rests = True
        self._loop.call_later(APART, self._next)

    def _next(self) -> None:
        self._rests = False
        self._is_busy = bool(self._waiting)
        if not self._waiting:
            self._overflows = False
            return
        data, stops = self._waiting.popleft()
        self._size -= len(data)
        request = _read(data)
        if request is None:
            self.refuse(data, "misuse", "expected a JSON object in a line, its id a number or text")
            self.done()
        else:
            self._server.desk.serve(self, request, stops)
        while self._waiting and _is_answer(self._waiting[0][0]):  # to this one, and no earlier
            data, stops = self._waiting.popleft()
            self._size -= len(data)
            self._server.desk.answer(self, _read(data) or {}, stops)

    def leave(self) -> None:
        """It has gone: what waits is not carried out."""
        self._waiting.clear()
        self._server.desk.gone(self)

    def drop(self) -> None:
        """Make it go."""
        self._writer.transport.abort()

    def refuse(self, data: bytes | None, code: str, text: str) -> None:
        """Say why a line is not carried out."""
        request = _read(data) if data else None
        self._write(line({"id": (request or {}).get("id"), "code": code, "text": text}))


def _read(data: bytes) -> dict[str, Any] | None:
    """A request, with an id that can be repeated; None when it is none."""
    try:
        request = message(data)
    except ValueError:
        return None
    number = request.get("id")
    is_id = number is None or isinstance(number, (int, str))
    if is_id and len(str(number)) <= _LONGEST_ID:
        return request
    return {**request, "id": None} if is_stop(request) else None


def _is_answer(data: bytes) -> bool:
    return (b'"answer"' in data or b'"give_up"' in data) and "words" not in (_read(data) or {})


class Server:
    """Listens while it is open."""

    def __init__(
        self, make_desk: Callable[[], Desk], stops: Stops, say: Callable[[str], None]
    ) -> None:
        """`make_desk` is called for the first client; `say(text)` when there can be no socket."""
        self._make_desk, self.stops, self._say = make_desk, stops, say
        self._name = f"{os.getpid()}{place.SUFFIX}"
        self._listening: socket.socket | None = None
        self._path = ""
        self._loop: asyncio.AbstractEventLoop | None = None
        self._over = asyncio.Event()
        self._open: dict[Client, None] = {}  # in the order in which they came
        self._thread = threading.Thread(target=self._run, name="socket", daemon=True)

    @cached_property
    def desk(self) -> Desk:
        """What carries out what comes."""
        return self._make_desk()

    def start(self) -> None:
        """Begin to listen."""
        try:
            self._listening = _listening(self._name)
        except OSError as error:
            self._say(f"no socket for other programs: {error.strerror or error}")
            return
        self._path = os.path.join(place.folder(), self._name)
        self._loop = asyncio.new_event_loop()
        self._thread.start()

    def close(self) -> None:
        """Listen no more; the socket goes."""
        if self._loop is None:  # it never did
            return
        with contextlib.suppress(OSError):
            os.unlink(self._path)
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(1.0)

    def _run(self) -> None:
        loop = self._loop
        assert loop is not None
        try:
            loop.run_until_complete(self._listen())
        finally:
            for client in list(self._open):  # each is served to its end: to cancel that is logged
                client.drop()
            serving = asyncio.all_tasks(loop)
            if serving:
                loop.run_until_complete(asyncio.wait(serving, timeout=1.0))
            loop.run_until_complete(asyncio.sleep(0))  # a connection closes a turn after its end
            loop.close()

    def takes_all_of(self, client: Client) -> bool:
        """False for one that comes on top of too many."""
        return client in islice(self._open, MOST_CLIENTS)

    async def _listen(self) -> None:
        if sys.platform != "win32":
            server = await asyncio.start_unix_server(self._serve, sock=self._listening)
            await self._over.wait()
            server.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        pid, uid = _peer(writer.get_extra_info("socket"))
        if uid is not None and hasattr(os, "getuid") and uid != os.getuid():
            writer.transport.abort()
            return
        client, lines = Client(self, writer, pid), LineCutter()
        self._open[client] = None
        if len(self._open) > MOST_OPEN:
            surplus = next(islice(self._open, MOST_CLIENTS, None))
            del self._open[surplus]
            surplus.drop()
        last = -_REST
        try:
            client.tell(self.desk.hello())
            while chunk := await reader.read(_CHUNK):
                for data in lines.take(chunk):
                    if data.strip() or data == TOO_LONG:
                        client.take(data)
                if time.monotonic() - last < _REST:  # a flood
                    await asyncio.sleep(_REST * min(len(self._open), MOST_CLIENTS))
                last = time.monotonic()
        except OSError:
            pass  # it was dropped, or has gone
        finally:
            self._open.pop(client, None)
            client.leave()
            client.drop()  # it reads no more: what is not sent would keep the connection open


def _listening(name: str) -> socket.socket:
    """A socket that is ours alone from its first moment. Raises OSError."""
    if sys.platform == "win32" or not hasattr(os, "fchmod"):
        raise OSError("Windows has none that Python knows")
    folder = place.folder()
    os.makedirs(os.path.dirname(folder), exist_ok=True)
    with contextlib.suppress(FileExistsError):
        os.mkdir(folder, 0o700)
    fault = place.fault(folder)
    if fault:
        raise OSError(fault)
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    held = os.open(folder, os.O_RDONLY)
    try:
        os.fchmod(made.fileno(), 0o600)
        # under another name until it listens: one that refuses is taken for a dead console's
        hidden = f".{name}.new"
        with contextlib.suppress(FileNotFoundError):  # of a process that had this number before
            os.unlink(hidden, dir_fd=held)
        made.bind(place.short(held, hidden))
        made.listen(128)
        made.setblocking(False)
        os.rename(hidden, name, src_dir_fd=held, dst_dir_fd=held)
    except BaseException:
        made.close()
        raise
    finally:
        os.close(held)
    return made


def _peer(connected: Any) -> tuple[int, int | None]:
    """Process and user at the other end; 0 and None where the system does not say."""
    if sys.platform == "linux":
        raw = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        pid, uid, _ = struct.unpack("3i", raw)
        return pid, uid
    return 0, None
