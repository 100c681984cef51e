"""The server of the console's socket, to which programs of the same user send requests.

A thread for each client reads, another one writes: a STOP is counted as it is read, also when its
client has gone, and a client that floods, or does not read its replies, delays no other. Requests
of one client are carried out one after the other; a STOP overtakes them.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import secrets
import selectors
import socket
import struct
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from itertools import islice
from typing import TYPE_CHECKING, Any

from archo_tui.client import sockets
from archo_tui.client.protocol import decode, encode, is_stop, words_of
from archo_tui.console.typing import TOO_LONG, LineSplitter
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.words import is_stop as is_stop_line

if TYPE_CHECKING:
    from archo_tui.console.session import RequestHandler

MAX_CLIENTS = 16  # Further clients may send STOP and nothing else.
MAX_CONNECTIONS = 64  # Beyond them the oldest of those further clients is dropped.
MAX_WAITING = 256 * 1024  # Bytes of waiting requests of one client.
MAX_UNREAD = 256 * 1024  # Bytes that a client has not read; beyond them it is dropped.
_CHUNK = 64 * 1024
_RETRY = 0.1  # Seconds until connections are accepted again where no descriptor is free.
_FLOOD_PAUSE = 0.004  # Seconds between two chunks of all clients: the screen needs time, too.
_END = 1.0  # Seconds in which what the clients have sent is still read at the end.
_MAX_ID = 100  # Characters.
_DAY = 86_400.0  # Seconds; systemd-tmpfiles removes from /tmp what nobody has touched for ten days.


class SocketClient:
    """A connected program: the requests of it that wait, and the replies that it has not read."""

    requester = ask = None  # It acts for itself, and is asked by a reply.

    def __init__(self, server: Server, connected: socket.socket) -> None:
        self._server, self._socket = server, connected
        self.pid, self._uid = _pid_and_uid(connected)
        self._replies: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._is_cut_off = False  # It has left, or was dropped: only a STOP of it counts.
        self._lock = threading.Lock()  # Held while the attributes below are used.
        self._unread = 0  # Bytes in `_replies`, or being written.
        self._waiting: deque[tuple[dict[str, Any], int, int]] = deque()
        self._waiting_bytes = 0
        self._is_busy = self._is_overflowing = False

    # Called on any thread.

    def reply(self, reply: dict[str, Any]) -> None:
        """Send a reply, without waiting; a client that leaves 256 kB unread is disconnected."""
        if self._unread > MAX_UNREAD:
            self.drop()
            return
        data = encode(reply)
        with self._lock:
            self._unread += len(data)
        self._replies.put(data)

    def on_request_ended(self) -> None:
        """Hand the next waiting request to the handler."""
        with self._lock:
            self._is_busy = bool(self._waiting)
            if not self._waiting:
                self._is_overflowing = False
                return
            request, stops, size = self._waiting.popleft()
            self._waiting_bytes -= size
        self._server.handler.serve(self, request, stops)

    @property
    def is_behind(self) -> bool:
        """True while the client has not read all replies."""
        return self._unread > 0

    def drop(self) -> None:
        """Shut the connection down; of what was sent already, only a STOP is still carried out."""
        self._is_cut_off = True
        with contextlib.suppress(OSError):  # It has left already.
            self._socket.shutdown(socket.SHUT_RDWR)

    # Called on the client's own threads.

    def run(self) -> None:
        """Read until the client has left, and close the connection."""
        if self._uid not in (None, sockets.uid()):
            self._socket.close()
            self._server.forget(self)
            return
        writing = threading.Thread(target=self._write, name="replies", daemon=True)
        writing.start()
        self.reply(self._server.hello)
        splitter, last = LineSplitter(), -_FLOOD_PAUSE
        with contextlib.suppress(OSError):
            while chunk := self._socket.recv(_CHUNK):
                for line in splitter.feed(chunk):
                    if line.strip() or line == TOO_LONG:
                        self.on_line(line)
                if time.monotonic() - last < _FLOOD_PAUSE:
                    time.sleep(_FLOOD_PAUSE * self._server.count)
                last = time.monotonic()
        for line in splitter.feed(b"\n"):  # An unfinished line is no request, but may be STOP.
            if _stop_in(line, self._server.stops) is not None:
                self.on_line(line)
        with self._lock:
            self._waiting.clear()
        self._server.handler.on_client_left(self)
        self.drop()
        self._replies.put(b"")
        writing.join()
        self._socket.close()
        self._server.forget(self)

    def _write(self) -> None:
        try:
            while data := self._replies.get():
                self._socket.sendall(data)
                with self._lock:
                    self._unread -= len(data)
        except OSError:  # It has left; what it has sent before is read to its end.
            self._is_cut_off = True

    def on_line(self, line: bytes) -> None:
        """Handle a line that the client sent: a STOP or an answer at once, other requests in turn.

        Of a client that has left or was dropped, all but a STOP is ignored.
        """
        stops, handler = self._server.stops, self._server.handler
        request = None if line == TOO_LONG else _stop_in(line, stops)
        if request is not None:
            handler.serve(self, request, stops.register())
            return
        if self._is_cut_off:
            return
        request = None if line == TOO_LONG else _request_in(line)
        if not self._server.takes_all_requests_of(self):
            self._refuse(request, f"{MAX_CLIENTS} clients are connected: only stop is taken")
        elif line == TOO_LONG:
            self._refuse(None, "a line of more than 64 kB", "misuse")
        elif request is None:
            text = "expected a JSON object in a line, its id a number or text"
            self._refuse(None, text, "misuse")
        elif any(sign in request for sign in ("give_up", "beat")) or (
            "answer" in request and self._is_busy
        ):
            handler.on_answer(self, request)
        else:
            self._serve_in_turn(request, stops.count, len(line))

    def _serve_in_turn(self, request: dict[str, Any], stops: int, size: int) -> None:
        with self._lock:
            is_full = self._waiting_bytes + size > MAX_WAITING
            is_told, self._is_overflowing = self._is_overflowing, self._is_overflowing or is_full
            if self._is_busy and not is_full:
                self._waiting.append((request, stops, size))
                self._waiting_bytes += size
            is_next, self._is_busy = not self._is_busy, True
        if is_next:
            self._server.handler.serve(self, request, stops)
        elif is_full and not is_told:
            self._refuse(request, "too many requests wait")

    def _refuse(self, request: dict[str, Any] | None, text: str, code: str = "refused") -> None:
        self.reply({"id": (request or {}).get("id"), "code": code, "text": text})


def _request_in(line: bytes) -> dict[str, Any] | None:
    """Return the request in a line; None if it is no JSON object or its id cannot be repeated.

    A STOP with such an id is returned all the same, with None as its id.
    """
    try:
        request = decode(line)
    except ValueError:
        return None
    number = request.get("id")
    is_id = number is None or isinstance(number, (int, str))
    if is_id and len(str(number)) <= _MAX_ID:
        return request
    return {**request, "id": None} if is_stop(request) else None


def _stop_in(line: bytes, stops: Stops) -> dict[str, Any] | None:
    """Return the request of a STOP in a line, plain text and calls of its service included."""
    text = line.replace(b"\0", b"").lower()
    if not any(word in text for word in (b"stop", b"call", b"\\u")):  # Nearly no line has one.
        return None
    request = _request_in(line)
    if request is None:
        return {"words": ["stop"]} if is_stop_line(line) else None
    with contextlib.suppress(ValueError):
        if stops.is_stop_call(words_of(request)):
            return {**request, "words": ["stop"]}
    return request if is_stop(request) else None


class Server:
    """The server of the console's socket; `notify` is called if no socket can be opened."""

    def __init__(
        self,
        make_handler: Callable[[], RequestHandler],
        hello: dict[str, Any],
        stops: Stops,
        notify: Callable[[str], None],
    ) -> None:
        self._make_handler, self.stops, self._notify = make_handler, stops, notify
        self._handler: RequestHandler | None = None
        self.hello = hello  # `start` adds the name of the socket.
        self._listening: socket.socket | None = None
        self._path = ""
        self._early: list[socket.socket] = []  # Connected before this process.
        self._clients: dict[SocketClient, None] = {}  # In the order in which they came.
        self._lock = threading.Lock()  # Held while clients come and go.
        self._is_ending = False
        self._awake, self._wake = socket.socketpair()  # Wakes the thread for its end.
        self._thread = threading.Thread(target=self._accept, name="socket", daemon=True)

    @property
    def handler(self) -> RequestHandler:
        """The request handler, which is made at the first use."""
        with self._lock:
            if self._handler is None:
                self._handler = self._make_handler()
            return self._handler

    def start(self) -> None:
        """Make the socket and its card, and start the thread."""
        if self._listening is None:
            # A process in another container may have the same number: the name needs more.
            self.hello = {**self.hello, "name": f"{os.getpid()}-{secrets.token_hex(4)}"}
            try:
                self._listening, self._path = open_socket(self.hello)
            except OSError as error:
                self._notify(f"no socket for other programs: {error.strerror or error}")
                return
        self._thread.start()

    def adopt(self, descriptor: int, path: str) -> None:
        """Listen on the socket of the process before a restart, once `start` is called.

        A STOP that was sent to it meanwhile is counted now, and carried out then.
        """
        os.set_inheritable(descriptor, False)
        self._listening, self._path = socket.socket(fileno=descriptor), path
        self._listening.setblocking(False)
        name = os.path.basename(path).removesuffix(sockets.SUFFIX)
        self.hello = {**self.hello, "name": name}
        with contextlib.suppress(OSError):  # No more wait.
            _write_card(path, self.hello, "w")
            while len(self._early) < MAX_CONNECTIONS:
                self._early.append(self._listening.accept()[0])
        for connected in self._early:
            with contextlib.suppress(OSError):  # It has sent nothing, or has left.
                connected.setblocking(False)
                sent = connected.recv(MAX_WAITING, socket.MSG_PEEK)
                for line in LineSplitter().feed(sent + b"\n"):
                    if _stop_in(line, self.stops) is not None:
                        self.stops.register()
            connected.setblocking(True)

    def keep(self) -> tuple[int, str] | None:
        """Disconnect all clients, and return the socket for the process that follows, and its path.

        It still listens; who connects waits for that process. None if it never listened.
        """
        listening = self._listening
        if listening is None:
            return None
        self._end_clients()
        descriptor = listening.detach()
        os.set_inheritable(descriptor, True)
        return descriptor, self._path

    def close(self) -> None:
        """End listening, remove the socket and its card, and disconnect all clients.

        Waits up to 1 s while what the clients have sent is still read.
        """
        if self._path:
            sockets.remove(self._path)
        self._end_clients()
        for each in (self._listening, *self._early):
            if each is not None:
                each.close()

    def _end_clients(self) -> None:
        self._is_ending = True
        self._wake.send(b"end")
        if self._thread.is_alive():
            self._thread.join(_END)
        end = time.monotonic() + _END
        while self._clients and time.monotonic() < end:  # What each has sent is still read.
            with self._lock:
                for client in self._clients:
                    client.drop()
            time.sleep(0.005)
        self._wake.close()
        self._awake.close()

    # Called on the threads.

    def takes_all_requests_of(self, client: SocketClient) -> bool:
        with self._lock:
            return client in islice(self._clients, MAX_CLIENTS)

    @property
    def count(self) -> int:
        """The number of clients whose requests are taken."""
        return min(len(self._clients), MAX_CLIENTS)

    def forget(self, client: SocketClient) -> None:
        with self._lock:
            self._clients.pop(client, None)

    def _accept(self) -> None:
        assert self._listening is not None
        while self._early:
            self.greet(self._early.pop(0))
        self._listening.setblocking(False)
        with selectors.DefaultSelector() as selector:
            selector.register(self._listening, selectors.EVENT_READ)
            selector.register(self._awake, selectors.EVENT_READ)
            while not self._is_ending:
                if not selector.select(_DAY):
                    for path in (self._path, sockets.card_path(self._path)):
                        with contextlib.suppress(OSError):
                            os.utime(path)
                try:
                    self.greet(self._listening.accept()[0])
                except BlockingIOError:  # The client has left.
                    pass
                except OSError:  # No descriptor is free: the client waits.
                    time.sleep(_RETRY)

    def greet(self, connected: socket.socket) -> None:
        """Serve a client on a connected socket."""
        connected.setblocking(True)
        client = SocketClient(self, connected)
        with self._lock:
            self._clients[client] = None
            if len(self._clients) > MAX_CONNECTIONS:
                surplus = next(islice(self._clients, MAX_CLIENTS, None))
                del self._clients[surplus]
                surplus.drop()
        try:
            threading.Thread(target=client.run, name="requests", daemon=True).start()
        except RuntimeError as error:  # No thread is free: the next client may have one.
            self.forget(client)
            connected.close()
            raise OSError(str(error)) from None


def open_socket(hello: dict[str, Any]) -> tuple[socket.socket, str]:
    """Return a listening socket for this user alone, and its path, or raise OSError.

    The card is there before the socket, and the socket listens before it has its name: clients
    remove one that refuses them.
    """
    folder = sockets.folder()
    if not folder or sys.platform == "win32" or not hasattr(os, "getuid"):
        raise OSError("this system has no sockets for it")
    with contextlib.suppress(FileExistsError):
        os.makedirs(os.path.dirname(folder), exist_ok=True)
        os.mkdir(folder, 0o700)
    if fault := sockets.folder_fault(folder):
        raise OSError(fault)
    path = os.path.join(folder, hello["name"] + sockets.SUFFIX)
    _write_card(path, hello, "x")  # Exclusively: no other console can have the name.
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    hidden = os.path.join(folder, f".{hello['name']}.new")
    try:
        made.bind(hidden)
        os.chmod(hidden, 0o600)
        made.listen(128)
        os.rename(hidden, path)
    except BaseException:
        made.close()
        sockets.remove(path)
        with contextlib.suppress(OSError):
            os.unlink(hidden)
        raise
    return made, path


def _write_card(path: str, hello: dict[str, Any], mode: str) -> None:
    with open(sockets.card_path(path), mode, encoding="utf-8") as file:
        json.dump(hello, file)


def _pid_and_uid(connected: socket.socket) -> tuple[int, int | None]:
    """Return the process id and user id of a client; 0 and None on any system but Linux."""
    if sys.platform == "linux":
        raw = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        pid, uid, _ = struct.unpack("3i", raw)
        return pid, uid
    return 0, None
