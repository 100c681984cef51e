"""A connection to a console's socket. Imports little, and only of the standard library."""

from __future__ import annotations

import contextlib
import os
import time

from archo_tui.remote import socket_files
from archo_tui.remote.protocol import GONE, PROTOCOL, decode, encode

TYPE_CHECKING = False
if TYPE_CHECKING:
    import socket
    from collections.abc import Iterator
    from typing import Any

_NO_ANSWER = "the console does not answer"
UNANSWERED = "the console does not answer; the robot may still be moving"


class Unreached(Exception):
    """The error for a request that no console answered: none runs, several do, or none answers."""


class Silent(Unreached):
    """The error for a console that did not send what was waited for in time."""


class Connection:
    """A connection to one console.

    At first no method blocks, so that one thread can connect to several consoles at once. After
    `set_blocking`, `request` and `remaining_replies` wait for the console.

    Attributes:
        path: The path of the socket.
        card: The copy of the hello in the file beside the socket; None if there is no such file.
        hello: The console's first message, which describes it; empty until it has come.
        result: The result of the request that was sent on connecting; None until it has come.
        is_dead: True if no process listens on the socket.
        has_gone: True if the connection broke or could not be made, though the socket exists.
        socket: The connected socket, also after it was closed; None before that.
    """

    def __init__(self, path: str, card: dict[str, Any] | None = None) -> None:
        """Create the connection without connecting.

        Args:
            path: The path of the socket.
            card: The result of `socket_files.read_card` for the socket.
        """
        self.path, self.card = path, card
        self.hello: dict[str, Any] = {}
        self.result: dict[str, Any] | None = None
        self.is_dead = False
        self.has_gone = False
        self.socket: socket.socket | None = None
        self._buffer = b""
        self._number = 0

    # Without waiting: see `finder.py`.

    def connect(self, first: bytes) -> None:
        """Try to connect, without waiting, and send `first` before the hello has come.

        Errors are not raised: `is_dead` or `has_gone` is set instead. The files of a console that
        was killed are removed. If too many connections wait, `socket` stays None and the caller
        tries again.

        Args:
            first: The request as bytes; b"" for none.
        """
        try:
            self.socket = socket_files.connect(self.path)
            if first:
                self.socket.send(first)  # It fits: the buffer is empty.
        except BlockingIOError:  # Too many connections wait: the caller tries again.
            pass
        except (ConnectionRefusedError, FileNotFoundError) as error:
            self.is_dead = True
            if isinstance(error, ConnectionRefusedError):  # Its console was killed.
                socket_files.remove(self.path)
        except OSError:
            self.has_gone = True

    def receive(self) -> None:
        """Read what the console has sent, without waiting, and set `hello` and `result` from it.

        Sets `has_gone` if the console has closed the connection or sent what is no message.
        Messages behind the result stay unread.
        """
        assert self.socket is not None
        try:
            chunk = self.socket.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        self._buffer += chunk
        try:
            while not self.result and (reply := self._next_message()) is not None:
                if "code" in reply:
                    self.result = reply
                elif not self.hello:
                    self.hello = reply
        except ValueError:
            chunk = b""
        self.has_gone = self.has_gone or not chunk

    @property
    def fault(self) -> str:
        """The reason why this console takes no verb, such as no hello yet; "" if it takes verbs.

        A console that only watches has no fault.
        """
        if not self.hello:
            return f"{self.short_description} does not answer: is it suspended?"
        protocol = self.hello.get("protocol")
        if protocol != PROTOCOL:
            return (
                f"the console of pid {self.hello.get('pid')} speaks protocol {protocol}, "
                f"this archo-tui {PROTOCOL}: use the same version of both"
            )
        return "" if _names_console(self.hello) and not self.has_gone else _NO_ANSWER

    @property
    def short_description(self) -> str:
        """The words `the console of pid N, NAMESPACE,`; without hello and card only the pid."""
        if self.identity:
            return f"the console of pid {self.identity['pid']}, {self.identity['namespace']},"
        pid = os.path.basename(self.path).partition(socket_files.SUFFIX)[0].partition("-")[0]
        return f"the console of pid {pid}"

    @property
    def identity(self) -> dict[str, Any]:
        """The robot, namespace, engine and pid of the console, among other values of a hello.

        They are those of the hello or, until a valid hello has come, those of the card: the file
        beside the socket with a copy of the hello. Empty if neither names the console.
        """
        return next(
            (hello for hello in (self.hello, self.card) if hello and _names_console(hello)), {}
        )

    @property
    def description(self) -> str:
        """The console in a line: `pid 7: ROBOT NAMESPACE, ENGINE domain 0`, with `, watching`.

        Before the hello it is what the card or the socket's name tells, at least the pid.
        """
        identity = self.identity
        if not identity:
            return self.short_description.removeprefix("the console of ")
        domain = "" if identity.get("domain") is None else f" domain {identity['domain']}"
        where = f"{identity['robot']} {identity['namespace']}, {identity['engine']}{domain}"
        return f"pid {identity['pid']}: {where}{', watching' if identity.get('watching') else ''}"

    # Waiting, once the hello has come.

    def set_blocking(self) -> None:
        """Make the socket blocking, so that later calls wait for the console."""
        assert self.socket is not None
        self.socket.settimeout(None)

    def request(
        self, total_timeout: float | None = None, **fields: Any
    ) -> Iterator[dict[str, Any]]:
        """Send a request, and yield all replies to it, the result last.

        Nothing is sent before the iterator is first advanced. Replies to other requests are
        dropped; those without an `id` are not.

        Args:
            total_timeout: Seconds for all replies together; None for any time.
            **fields: The fields of the request, as docs/protocol.md lists them.

        Raises:
            Silent: The result did not come in time. A subclass of Unreached.
            Unreached: The console has gone.
        """
        self._number += 1
        number = self._number
        self.send({"id": number, **fields})
        for reply in self.remaining_replies(total_timeout):
            if reply.get("id") in (number, None):
                yield reply
                if "code" in reply:
                    return

    def remaining_replies(self, total_timeout: float | None = None) -> Iterator[dict[str, Any]]:
        """Yield all further messages of the console, whichever request they are for.

        The iterator never ends without an error.

        Args:
            total_timeout: Seconds for all messages together, from the first `next` on; None for any
                time.

        Raises:
            Silent: The time is over.
            Unreached: The console has gone.
        """
        assert self.socket is not None
        end = None if total_timeout is None else time.monotonic() + total_timeout
        try:
            while True:
                while (reply := self._next_message()) is not None:
                    yield reply
                self.socket.settimeout(None if end is None else max(end - time.monotonic(), 0.001))
                chunk = self.socket.recv(65536)
                if not chunk:
                    break
                self._buffer += chunk
        except TimeoutError:
            raise Silent(UNANSWERED) from None
        except (OSError, ValueError):  # A broken connection counts as an ended one.
            pass
        finally:
            with contextlib.suppress(OSError):
                self.socket.settimeout(None)
        raise Unreached(GONE)

    def send(self, request: dict[str, Any]) -> None:
        """Send a request, an answer, or `give_up`, as docs/protocol.md lists them.

        Args:
            request: The whole message, with an `id` if it needs one.

        Raises:
            Unreached: The console has gone.
        """
        assert self.socket is not None
        try:
            self.socket.sendall(encode(request))
        except OSError:
            raise Unreached(GONE) from None

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self.socket is not None:
            self.socket.close()

    def detach(self) -> tuple[socket.socket, bytes]:
        """Return the socket, and the bytes that were read from it and not parsed yet.

        The caller reads and closes the socket from now on.
        """
        assert self.socket is not None
        return self.socket, self._buffer

    def _next_message(self) -> dict[str, Any] | None:
        """Remove the next whole line from the buffer and return its message.

        Returns:
            The message; None if no line is whole yet.

        Raises:
            ValueError: The line is no JSON object.
        """
        data, found, rest = self._buffer.partition(b"\n")
        if not found:
            return None
        self._buffer = rest
        return decode(data)


def _names_console(hello: dict[str, Any]) -> bool:
    """Return True if a hello has the robot, namespace, engine and pid of its console."""
    texts = all(isinstance(hello.get(name), str) for name in ("robot", "namespace", "engine"))
    return texts and type(hello.get("pid")) is int
