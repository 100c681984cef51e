"""The console's socket: takes what programs of the same user send, on a thread of its own.

Requests of one client are carried out one after the other; STOP is read ahead of them, counted as
it is read, and waits for nothing. Whoever floods or does not read delays nobody else.

A STOP is read also when its client has gone: sockets are read and written apart from each other,
because asyncio's streams drop what is unread as soon as something cannot be written.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import secrets
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

from archo_tui.plain import lines
from archo_tui.remote import place
from archo_tui.remote.protocol import NOT_MEANT, is_meant, is_stop, line, message, words_of
from archo_tui.robot.stops import Stops

MOST_CLIENTS = 16  # a further one may send STOP and nothing else
MOST_OPEN = 64  # of these further ones the oldest goes for the next
MOST_WAITING = 256 * 1024  # bytes of requests of one client that wait
MOST_UNREAD = 256 * 1024  # bytes that a client has not read; then it is dropped
APART = 0.02  # s between two requests of one client
_CHUNK = 64 * 1024
_AT_ONCE = 256 * 1024  # bytes that are read before the hello: what a client has sent and gone
_RETRY = 0.1  # s after which connections are taken again, where there is no descriptor for one
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

    def serve(self, client: Guest, request: dict[str, Any], stops: int) -> None:
        """Begin to carry it out; `client.done()` is called when that has ended."""

    def answer(self, client: Guest, answer: dict[str, Any], stops: int) -> None:
        """What a client says while its request is carried out."""

    def gone(self, client: Guest) -> None:
        """It has left."""


class Client:
    """One program that is connected."""

    def __init__(self, server: Server, connected: socket.socket, pid: int) -> None:
        self.pid = pid
        self._server, self._socket = server, connected
        self._loop = asyncio.get_running_loop()
        self._unread = bytearray()  # what is still to be written
        self._writing: asyncio.Task[None] | None = None
        self._is_deaf = False  # it reads no more
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
        if self._is_deaf:
            return
        if len(self._unread) > MOST_UNREAD:
            self.drop()
            return
        self._unread += data
        if self._writing is None:
            self._writing = self._loop.create_task(self._write_all())

    async def _write_all(self) -> None:
        try:
            while self._unread and not self._is_deaf:
                data = bytes(self._unread[:_CHUNK])
                await self._loop.sock_sendall(self._socket, data)
                del self._unread[: len(data)]
        except OSError:  # it has gone; what it has sent before is read to its end
            self._is_deaf = True
        finally:
            self._writing = None

    def take(self, data: bytes) -> None:
        """One line that it sent."""
        stops = self._server.stops
        if data == lines.TOO_LONG:
            self.refuse(None, "misuse", "a line of more than 64 kB")
            return
        request = _stop_in(data, stops)
        if request is not None and not is_meant(request, self._server.hello):
            self.refuse(data, NOT_MEANT, "this STOP is meant for another console")
        elif request is not None:
            self._server.desk.serve(self, request, stops.register())
        elif self._is_deaf:  # it has gone, or was dropped: but for STOP nothing of it is done
            pass
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
        """Make it go, once what it has sent is read."""
        self._is_deaf = True
        with contextlib.suppress(OSError):  # it has gone already
            self._socket.shutdown(socket.SHUT_RDWR)

    async def close(self) -> None:
        """Close the socket, when nothing is written to it any more."""
        self.drop()
        if self._writing is not None:  # which now fails
            await asyncio.wait([self._writing])
        self._socket.close()

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


def _stop_in(data: bytes, stops: Stops) -> dict[str, Any] | None:
    """Return the request when a line is a STOP.

    It may be typed and no JSON, or `call` the service of the robot's STOP.
    """
    text = data.replace(b"\0", b"").lower()
    if not any(word in text for word in (b"stop", b"call", b"\\u")):  # nearly no line has one
        return None
    request = _read(data)
    if request is None:
        return {"words": ["stop"]} if lines.is_stop(data) else None
    if stops.is_stop_call(_words(request)):
        return {**request, "words": ["stop"]}
    return request if is_stop(request) else None


def _words(request: dict[str, Any]) -> list[str]:
    try:
        return words_of(request)
    except ValueError:
        return []


def _is_answer(data: bytes) -> bool:
    return (b'"answer"' in data or b'"give_up"' in data) and "words" not in (_read(data) or {})


class Server:
    """Listens while it is open."""

    def __init__(
        self,
        make_desk: Callable[[], Desk],
        hello: dict[str, Any],
        stops: Stops,
        say: Callable[[str], None],
    ) -> None:
        """Opens nothing yet.

        Args:
            make_desk: Is called for the first client.
            hello: What every client is told first, but for the name of the socket.
            stops: Counts each STOP as it is read.
            say: Is told when there can be no socket.
        """
        self._make_desk, self.stops, self._say = make_desk, stops, say
        self.hello = hello
        self._listening: socket.socket | None = None
        self._path = ""
        self._loop: asyncio.AbstractEventLoop | None = None
        self._open: dict[Client, None] = {}  # in the order in which they came
        self._serving: set[asyncio.Task[None]] = set()
        self._taking: asyncio.Task[None] | None = None
        self._thread = threading.Thread(target=self._run, name="socket", daemon=True)

    @cached_property
    def desk(self) -> Desk:
        """What carries out what comes."""
        return self._make_desk()

    def start(self) -> None:
        """Begin to listen."""
        # a name that no console had before: in another container there may be one of our number
        name = f"{os.getpid()}-{secrets.token_hex(4)}"
        self.hello = {**self.hello, "name": name}
        try:
            self._listening, self._path = _listening(self.hello)
        except OSError as error:
            self._say(f"no socket for other programs: {error.strerror or error}")
            return
        _link(self._path)
        self._loop = asyncio.new_event_loop()
        self._taking = self._loop.create_task(self._take_clients(self._listening))
        self._thread.start()

    def close(self) -> None:
        """Listen no more; the socket goes."""
        if self._loop is None or self._taking is None:  # it never did
            return
        place.forget(self._path)
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._taking.cancel)
        self._thread.join(1.0)

    def _run(self) -> None:
        loop = self._loop
        assert loop is not None
        assert self._taking is not None
        assert self._listening is not None
        try:
            with contextlib.suppress(asyncio.CancelledError):
                loop.run_until_complete(self._taking)
        finally:
            self._listening.close()
            for client in list(self._open):  # each is served to its end
                client.drop()
            if self._serving:
                # a copy: the last one may be discarded before the wait begins, and none is an error
                loop.run_until_complete(asyncio.wait([*self._serving], timeout=1.0))
            loop.close()

    def takes_all_of(self, client: Client) -> bool:
        """False for one that comes on top of too many."""
        return client in islice(self._open, MOST_CLIENTS)

    async def _take_clients(self, listening: socket.socket) -> None:
        loop = asyncio.get_running_loop()
        while True:
            try:
                connected, _ = await loop.sock_accept(listening)
            except OSError:  # no descriptor is free: the client waits
                await asyncio.sleep(_RETRY)
                continue
            serving = loop.create_task(self._serve(connected))
            self._serving.add(serving)
            serving.add_done_callback(self._serving.discard)
            await asyncio.sleep(0)  # a flood of them delays no STOP

    async def _serve(self, connected: socket.socket) -> None:
        pid, uid = _peer(connected)
        if uid is not None and hasattr(os, "getuid") and uid != os.getuid():
            connected.close()
            return
        client, cutter = Client(self, connected, pid), lines.LineCutter()
        self._open[client] = None
        if len(self._open) > MOST_OPEN:
            surplus = next(islice(self._open, MOST_CLIENTS, None))
            del self._open[surplus]
            surplus.drop()
        read, last = _read_at_once(connected), -_REST
        self._take(client, cutter, read)  # before the hello: a STOP may be all that it had to say
        try:
            client.tell(self.hello)
            while chunk := await asyncio.get_running_loop().sock_recv(connected, _CHUNK):
                self._take(client, cutter, chunk)
                if time.monotonic() - last < _REST:  # a flood
                    await asyncio.sleep(_REST * min(len(self._open), MOST_CLIENTS))
                last = time.monotonic()
        except OSError:
            pass  # it was dropped, or has gone
        finally:
            for data in cutter.take(b"\n"):  # what is not ended is no request, but may be a STOP
                if _stop_in(data, self.stops) is not None:
                    client.take(data)
            self._open.pop(client, None)
            client.leave()
            await client.close()

    def _take(self, client: Client, cutter: lines.LineCutter, chunk: bytes) -> None:
        for data in cutter.take(chunk):
            if data.strip() or data == lines.TOO_LONG:
                client.take(data)


def _read_at_once(connected: socket.socket) -> bytes:
    """Return what a client has sent already."""
    connected.setblocking(False)
    read = bytearray()
    with contextlib.suppress(OSError):  # there is no more, or it has gone
        while len(read) < _AT_ONCE and (chunk := connected.recv(_CHUNK)):
            read += chunk
    return bytes(read)


def _listening(hello: dict[str, Any]) -> tuple[socket.socket, str]:
    """Return a socket that is ours alone from its first moment, and its path. Raises OSError."""
    if sys.platform == "win32" or not hasattr(os, "fchmod"):
        raise OSError("Windows has none that Python knows")
    folder = place.folder()
    if not folder:
        raise OSError("this user has no home, and XDG_RUNTIME_DIR is not set")
    place.make(folder)
    path = os.path.join(folder, f"{hello['name']}{place.SUFFIX}")
    # no other console can have this name: whoever has made the card has it
    exclusively = os.O_WRONLY | os.O_CREAT | os.O_EXCL
    card = os.open(path.removesuffix(place.SUFFIX) + place.CARD, exclusively, 0o600)
    with os.fdopen(card, "w", encoding="utf-8") as file:
        json.dump(hello, file)
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    held = os.open(folder, os.O_RDONLY)
    # under another name until it listens: one that refuses is taken for a dead console's
    hidden = f".{hello['name']}.new"
    try:
        os.fchmod(made.fileno(), 0o600)
        made.bind(place.short(held, os.path.join(folder, hidden)))
        made.listen(128)
        made.setblocking(False)
        os.rename(hidden, os.path.basename(path), src_dir_fd=held, dst_dir_fd=held)
    except BaseException:
        made.close()
        place.forget(path)
        with contextlib.suppress(OSError):
            os.unlink(hidden, dir_fd=held)
        raise
    finally:
        os.close(held)
    return made, path


def _link(path: str) -> None:
    """Link to a socket and its card from the user's home."""
    folder = place.link_folder()
    name = os.path.basename(path).removesuffix(place.SUFFIX)
    with contextlib.suppress(OSError):  # a home that cannot be written to
        if folder:
            place.make(folder)
            for suffix in (place.CARD, place.SUFFIX):
                target = path.removesuffix(place.SUFFIX) + suffix
                os.symlink(target, os.path.join(folder, name + suffix))


def _peer(connected: Any) -> tuple[int, int | None]:
    """Process and user at the other end; 0 and None where the system does not say."""
    if sys.platform == "linux":
        raw = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        pid, uid, _ = struct.unpack("3i", raw)
        return pid, uid
    return 0, None
