"""The server of the console's socket, to which programs of the same user send requests.

It has a thread and a loop of its own. Requests of one client are carried out one after the other;
a STOP is counted as it is read and overtakes them. A client that floods, or does not read its
replies, delays no other. A STOP is read also when its client has gone: sockets are read and
written independently, because asyncio's streams drop unread data as soon as a write fails.
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
from archo_tui.remote import socket_files
from archo_tui.remote.protocol import NOT_MEANT, decode, encode, is_meant, is_stop, words_of
from archo_tui.robot.stop.gate import Stops

MAX_CLIENTS = 16  # Further clients may send STOP and nothing else.
MAX_CONNECTIONS = 64  # Beyond them the oldest of those further clients is dropped.
MAX_WAITING = 256 * 1024  # Bytes of waiting requests of one client.
MAX_UNREAD = 256 * 1024  # Bytes that a client has not read; beyond them it is dropped.
REQUEST_INTERVAL = 0.02  # Seconds between two requests of one client.
_CHUNK = 64 * 1024
_FIRST_READ = 256 * 1024  # Bytes that are read before the hello, in case the client has left.
_RETRY = 0.1  # Seconds until connections are accepted again where no descriptor is free.
_FLOOD_PAUSE = 0.004  # Seconds between two chunks of all clients: the screen needs time, too.
_MAX_ID = 100  # Characters.


class ClientSession(Protocol):
    """The interface to a connected client; all of it may be used on any thread."""

    pid: int  # 0 if it is not known.

    def reply(self, reply: dict[str, Any]) -> None:
        """Send a reply to the client, without waiting."""

    def on_request_ended(self) -> None:
        """Record that the client's request has ended, and have its next one carried out."""

    @property
    def is_behind(self) -> bool:
        """True while the client has not read all replies."""


class HandlesRequests(Protocol):
    """The interface to the handler of requests; its methods are called on the server's thread."""

    def serve(self, client: ClientSession, request: dict[str, Any], stops: int) -> None:
        """Begin to carry out a request, and return at once.

        `client.on_request_ended()` must be called at its end, except for a STOP. `stops` are the
        STOPs read before the request; a STOP counts itself.
        """

    def on_answer(self, client: ClientSession, answer: dict[str, Any], stops: int) -> None:
        """Pass on a client's answer to a question, or call its request off at a `give_up`."""

    def on_client_left(self, client: ClientSession) -> None:
        """Call off the work that a client waits for, after its connection has closed."""


class Client:
    """A connected program: the requests of it that wait, and the replies that it has not read."""

    def __init__(self, server: Server, connected: socket.socket, pid: int) -> None:
        self.pid = pid  # 0 if it is not known.
        self._server, self._socket = server, connected
        self._loop = asyncio.get_running_loop()
        self._unread = bytearray()  # Still to be written.
        self._writing: asyncio.Task[None] | None = None
        self._is_cut_off = False  # It has left, or was dropped: only a STOP of it counts.
        self._waiting: deque[tuple[bytes, int]] = deque()
        self._waiting_bytes = 0  # Bytes of the waiting requests.
        self._is_busy = self._is_pausing = self._is_overflowing = False

    # Called on any thread.

    def reply(self, reply: dict[str, Any]) -> None:
        """Send a reply, without waiting; a client that leaves 256 kB unread is disconnected."""
        with contextlib.suppress(RuntimeError):  # The loop is closed.
            self._loop.call_soon_threadsafe(self._write, encode(reply))

    def on_request_ended(self) -> None:
        """Hand the next waiting request to the handler, 0.02 s from now."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._pause)

    @property
    def is_behind(self) -> bool:
        return bool(self._unread)

    # Called on the server's thread.

    def _write(self, data: bytes) -> None:
        if self._is_cut_off:
            return
        if len(self._unread) > MAX_UNREAD:
            self.drop()
            return
        self._unread += data
        if self._writing is None:
            self._writing = self._loop.create_task(self._write_all())

    async def _write_all(self) -> None:
        try:
            while self._unread and not self._is_cut_off:
                data = bytes(self._unread[:_CHUNK])
                await self._loop.sock_sendall(self._socket, data)
                del self._unread[: len(data)]
        except OSError:  # It has left; what it has sent before is read to its end.
            self._is_cut_off = True
        finally:
            self._writing = None

    def on_line(self, data: bytes) -> None:
        """Handle a line that the client sent: a STOP or an answer at once, other requests in turn.

        A STOP that means another console is refused. Of a client that has left or was dropped, all
        but a STOP is ignored.
        """
        stops = self._server.stops
        if data == lines.TOO_LONG:
            self.refuse(None, "misuse", "a line of more than 64 kB")
            return
        request = _stop_in(data, stops)
        if request is not None and not is_meant(request, self._server.hello):
            self.refuse(data, NOT_MEANT, "this STOP is meant for another console")
        elif request is not None:
            self._server.handler.serve(self, request, stops.register())
        elif self._is_cut_off:
            pass
        elif not self._server.takes_all_requests_of(self):
            self.refuse(data, "refused", f"{MAX_CLIENTS} clients are connected: only stop is taken")
        elif self._is_busy and _is_answer(data) and not (self._is_pausing and self._waiting):
            self._server.handler.on_answer(self, _parse_request(data) or {}, stops.count)
        elif self._waiting_bytes + len(data) > MAX_WAITING:
            if not self._is_overflowing:
                self.refuse(data, "refused", "too many requests wait")
            self._is_overflowing = True
        else:
            self._waiting.append((data, stops.count))
            self._waiting_bytes += len(data)
            if not self._is_busy:
                self._serve_next_line()

    def _pause(self) -> None:
        self._is_pausing = True
        self._loop.call_later(REQUEST_INTERVAL, self._serve_next_line)

    def _serve_next_line(self) -> None:
        """Hand the oldest waiting line to the handler, with the answers that follow it."""
        self._is_pausing = False
        self._is_busy = bool(self._waiting)
        if not self._waiting:
            self._is_overflowing = False
            return
        data, stops = self._waiting.popleft()
        self._waiting_bytes -= len(data)
        request = _parse_request(data)
        if request is None:
            self.refuse(data, "misuse", "expected a JSON object in a line, its id a number or text")
            self.on_request_ended()
        else:
            self._server.handler.serve(self, request, stops)
        while self._waiting and _is_answer(self._waiting[0][0]):  # To this request.
            data, stops = self._waiting.popleft()
            self._waiting_bytes -= len(data)
            self._server.handler.on_answer(self, _parse_request(data) or {}, stops)

    def on_left(self) -> None:
        self._waiting.clear()
        self._server.handler.on_client_left(self)

    def drop(self) -> None:
        """Shut the connection down; of what was sent already, only a STOP is still carried out."""
        self._is_cut_off = True
        with contextlib.suppress(OSError):  # It has left already.
            self._socket.shutdown(socket.SHUT_RDWR)

    async def close(self) -> None:
        """Drop the client, wait until the current write has failed, and close the socket."""
        self.drop()
        if self._writing is not None:  # It fails now.
            await asyncio.wait([self._writing])
        self._socket.close()

    def refuse(self, data: bytes | None, code: str, text: str) -> None:
        """Reply to a line that is not carried out; `data` is None if it was too long to be read."""
        request = _parse_request(data) if data else None
        self._write(encode({"id": (request or {}).get("id"), "code": code, "text": text}))


def _parse_request(data: bytes) -> dict[str, Any] | None:
    """Return the request in a line; None if it is no JSON object or its id cannot be repeated.

    A STOP with such an id is returned all the same, with None as its id.
    """
    try:
        request = decode(data)
    except ValueError:
        return None
    number = request.get("id")
    is_id = number is None or isinstance(number, (int, str))
    if is_id and len(str(number)) <= _MAX_ID:
        return request
    return {**request, "id": None} if is_stop(request) else None


def _stop_in(data: bytes, stops: Stops) -> dict[str, Any] | None:
    """Return the request of a STOP in a line, plain text and calls of its service included."""
    text = data.replace(b"\0", b"").lower()
    if not any(word in text for word in (b"stop", b"call", b"\\u")):  # Nearly no line has one.
        return None
    request = _parse_request(data)
    if request is None:
        return {"words": ["stop"]} if lines.is_stop(data) else None
    if stops.is_stop_call(_words_if_valid(request)):
        return {**request, "words": ["stop"]}
    return request if is_stop(request) else None


def _words_if_valid(request: dict[str, Any]) -> list[str]:
    try:
        return words_of(request)
    except ValueError:
        return []


def _is_answer(data: bytes) -> bool:
    return (b'"answer"' in data or b'"give_up"' in data) and "words" not in (
        _parse_request(data) or {}
    )


class Server:
    """The server of the console's socket, which reads the clients' requests on its thread."""

    def __init__(
        self,
        make_handler: Callable[[], HandlesRequests],
        hello: dict[str, Any],
        stops: Stops,
        notify: Callable[[str], None],
    ) -> None:
        self._make_handler, self.stops, self._notify = make_handler, stops, notify
        self.hello = hello  # `start` adds the name of the socket.
        self._listening: socket.socket | None = None
        self._path = ""
        self._is_kept = False  # True if the listening socket outlives the thread.
        self._early: list[socket.socket] = []  # Connected before this process.
        self._loop: asyncio.AbstractEventLoop | None = None
        self._clients: dict[Client, None] = {}  # In the order in which they came.
        self._serving: set[asyncio.Task[None]] = set()
        self._accepting: asyncio.Task[None] | None = None
        self._thread = threading.Thread(target=self._run, name="socket", daemon=True)

    @cached_property
    def handler(self) -> HandlesRequests:
        """The request handler, which is made at the first use, on the server's thread."""
        return self._make_handler()

    def start(self) -> None:
        """Make the socket and its card, and start the thread; `notify` is called if that fails."""
        # A process in another container may have the same number: the name needs more.
        if self._listening is None:
            name = f"{os.getpid()}-{secrets.token_hex(4)}"
            self.hello = {**self.hello, "name": name}
            try:
                self._listening, self._path = _open_socket(self.hello)
            except OSError as error:
                self._notify(f"no socket for other programs: {error.strerror or error}")
                return
            _link_from_home(self._path)
        self._loop = asyncio.new_event_loop()
        self._accepting = self._loop.create_task(self._accept_clients(self._listening))
        self._thread.start()

    def adopt(self, descriptor: int, path: str) -> None:
        """Listen on the socket of the process before a restart, once `start` is called.

        A STOP that was sent to it meanwhile is counted now, and carried out then.
        """
        os.set_inheritable(descriptor, False)
        self._listening, self._path = socket.socket(fileno=descriptor), path
        self._listening.setblocking(False)
        name = os.path.basename(path).removesuffix(socket_files.SUFFIX)
        self.hello = {**self.hello, "name": name}
        with contextlib.suppress(OSError):  # No more wait.
            _write_card(path, self.hello, os.O_TRUNC)
            while len(self._early) < MAX_CONNECTIONS:
                connected, _ = self._listening.accept()
                self._early.append(connected)
        for connected in self._early:
            with contextlib.suppress(OSError):
                connected.setblocking(False)
                sent = connected.recv(_FIRST_READ, socket.MSG_PEEK)
                for data in lines.LineSplitter().feed(sent + b"\n"):
                    request = _stop_in(data, self.stops)
                    if request is not None and is_meant(request, self.hello):
                        self.stops.register()

    def keep(self) -> tuple[int, str] | None:
        """Disconnect all clients, and return the socket for the process that follows, and its path.

        It still listens; who connects waits for that process. None if it never listened.
        """
        if self._listening is None:
            return None
        self._is_kept = True
        self.close()
        descriptor = self._listening.detach()
        os.set_inheritable(descriptor, True)
        return descriptor, self._path

    def close(self) -> None:
        """End listening, remove the socket and its card, and disconnect all clients.

        Waits up to 1 s while what the clients have sent is still read.
        """
        if self._path and not self._is_kept:
            socket_files.remove(self._path)
        if self._loop is None or self._accepting is None:  # It never listened.
            for adopted in (self._listening, *self._early):
                if adopted is not None:
                    adopted.close()
            return
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._accepting.cancel)
        self._thread.join(1.0)

    def _run(self) -> None:
        loop = self._loop
        assert loop is not None
        assert self._accepting is not None
        assert self._listening is not None
        try:
            with contextlib.suppress(asyncio.CancelledError):
                loop.run_until_complete(self._accepting)
        finally:
            if not self._is_kept:
                self._listening.close()
            for client in list(self._clients):  # What each has sent is still read.
                client.drop()
            if self._serving:
                # A copy: the set may become empty before the wait begins, which is an error.
                loop.run_until_complete(asyncio.wait([*self._serving], timeout=1.0))
            loop.close()

    def takes_all_requests_of(self, client: Client) -> bool:
        return client in islice(self._clients, MAX_CLIENTS)

    async def _accept_clients(self, listening: socket.socket) -> None:
        loop = asyncio.get_running_loop()
        while True:
            try:
                if self._early:
                    connected = self._early.pop(0)
                else:
                    connected, _ = await loop.sock_accept(listening)
            except OSError:  # No descriptor is free: the client waits.
                await asyncio.sleep(_RETRY)
                continue
            serving = loop.create_task(self._serve(connected))
            self._serving.add(serving)
            serving.add_done_callback(self._serving.discard)
            await asyncio.sleep(0)  # A flood of connections delays no STOP.

    async def _serve(self, connected: socket.socket) -> None:
        pid, uid = _pid_and_uid(connected)
        if uid is not None and hasattr(os, "getuid") and uid != os.getuid():
            connected.close()
            return
        client, splitter = Client(self, connected, pid), lines.LineSplitter()
        self._clients[client] = None
        if len(self._clients) > MAX_CONNECTIONS:
            surplus = next(islice(self._clients, MAX_CLIENTS, None))
            del self._clients[surplus]
            surplus.drop()
        read, last = _read_at_once(connected), -_FLOOD_PAUSE
        self._feed(client, splitter, read)  # Before the hello: it may have sent STOP and left.
        try:
            client.reply(self.hello)
            while chunk := await asyncio.get_running_loop().sock_recv(connected, _CHUNK):
                self._feed(client, splitter, chunk)
                if time.monotonic() - last < _FLOOD_PAUSE:  # A flood.
                    await asyncio.sleep(_FLOOD_PAUSE * min(len(self._clients), MAX_CLIENTS))
                last = time.monotonic()
        except OSError:
            pass  # It was dropped, or has left.
        finally:
            for data in splitter.feed(b"\n"):  # An unfinished line is no request, but may be STOP.
                if _stop_in(data, self.stops) is not None:
                    client.on_line(data)
            self._clients.pop(client, None)
            client.on_left()
            await client.close()

    def _feed(self, client: Client, splitter: lines.LineSplitter, chunk: bytes) -> None:
        for data in splitter.feed(chunk):
            if data.strip() or data == lines.TOO_LONG:
                client.on_line(data)


def _read_at_once(connected: socket.socket) -> bytes:
    """Make the socket non-blocking, and return the bytes sent already, up to 256 kB."""
    connected.setblocking(False)
    read = bytearray()
    with contextlib.suppress(OSError):  # There is no more, or it has left.
        while len(read) < _FIRST_READ and (chunk := connected.recv(_CHUNK)):
            read += chunk
    return bytes(read)


def _open_socket(hello: dict[str, Any]) -> tuple[socket.socket, str]:
    """Return a listening socket for this user alone, and its path, or raise OSError."""
    if sys.platform == "win32" or not hasattr(os, "fchmod"):
        raise OSError("Windows has none that Python knows")
    folder = socket_files.listening_folder()
    if not folder:
        raise OSError("this user has no home, and XDG_RUNTIME_DIR is not set")
    socket_files.make_folder(folder)
    path = os.path.join(folder, f"{hello['name']}{socket_files.SUFFIX}")
    # Creating the card exclusively reserves the name: no other console can have it.
    _write_card(path, hello, os.O_EXCL)
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    held = os.open(folder, os.O_RDONLY)
    # Bound under another name until it listens: clients remove a socket that refuses them.
    hidden = f".{hello['name']}.new"
    try:
        os.fchmod(made.fileno(), 0o600)
        made.bind(socket_files.short_path(held, os.path.join(folder, hidden)))
        made.listen(128)
        made.setblocking(False)
        os.rename(hidden, os.path.basename(path), src_dir_fd=held, dst_dir_fd=held)
    except BaseException:
        made.close()
        socket_files.remove(path)
        with contextlib.suppress(OSError):
            os.unlink(hidden, dir_fd=held)
        raise
    finally:
        os.close(held)
    return made, path


def _write_card(path: str, hello: dict[str, Any], flag: int) -> None:
    card = path.removesuffix(socket_files.SUFFIX) + socket_files.CARD_SUFFIX
    descriptor = os.open(card, os.O_WRONLY | os.O_CREAT | flag, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as file:
        json.dump(hello, file)


def _link_from_home(path: str) -> None:
    """Link a socket and its card from the user's home, where other clients look."""
    folder = socket_files.link_folder()
    name = os.path.basename(path).removesuffix(socket_files.SUFFIX)
    with contextlib.suppress(OSError):  # The home cannot be written to.
        if folder:
            socket_files.make_folder(folder)
            for suffix in (socket_files.CARD_SUFFIX, socket_files.SUFFIX):
                target = path.removesuffix(socket_files.SUFFIX) + suffix
                os.symlink(target, os.path.join(folder, name + suffix))


def _pid_and_uid(connected: Any) -> tuple[int, int | None]:
    """Return the process id and user id of a client; 0 and None on any system but Linux."""
    if sys.platform == "linux":
        raw = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        pid, uid, _ = struct.unpack("3i", raw)
        return pid, uid
    return 0, None
