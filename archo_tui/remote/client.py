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
    """A connection to one console; nothing blocks before `set_blocking`.

    So one thread can connect to several consoles at once.
    """

    def __init__(self, path: str, card: dict[str, Any] | None = None) -> None:
        # card: the hello in the file beside the socket; None without one
        self.path, self.card = path, card
        self.hello: dict[str, Any] = {}  # The first message; empty until it has come.
        self.result: dict[str, Any] | None = None  # Of the request that was sent on connecting.
        self.is_dead = False  # No process listens on the socket.
        self.has_gone = False  # The connection broke or could not be made.
        self.socket: socket.socket | None = None  # Also after it was closed.
        self._buffer = b""
        self._number = 0

    # Without waiting: see `finder.py`.

    def connect(self, first: bytes) -> None:
        """Try to connect, without waiting, and send `first` before the hello has come.

        Errors set `is_dead` or `has_gone`; the files of a killed console are removed. If too many
        connections wait, `socket` stays None: try again.
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
        """Read what the console has sent, without waiting, up to the result.

        Sets `has_gone` if the console has closed the connection or sent what is no message.
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
        """The reason why this console takes no verb, such as no hello yet; "" if it takes verbs."""
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
        """The hello or, until a valid one has come, the card; empty without either."""
        return next(
            (hello for hello in (self.hello, self.card) if hello and _names_console(hello)), {}
        )

    @property
    def description(self) -> str:
        """The console in a line: `pid 7: ROBOT NAMESPACE, ENGINE domain 0`, with `, watching`."""
        identity = self.identity
        if not identity:
            return self.short_description.removeprefix("the console of ")
        domain = "" if identity.get("domain") is None else f" domain {identity['domain']}"
        where = f"{identity['robot']} {identity['namespace']}, {identity['engine']}{domain}"
        return f"pid {identity['pid']}: {where}{', watching' if identity.get('watching') else ''}"

    # Waiting, once the hello has come.

    def set_blocking(self) -> None:
        """Make later calls wait for the console."""
        assert self.socket is not None
        self.socket.settimeout(None)

    def request(
        self, total_timeout: float | None = None, **fields: Any
    ) -> Iterator[dict[str, Any]]:
        """Send a request, and yield all replies to it, the result last.

        Nothing is sent before the iterator is first advanced. Raises Silent if the result does not
        come within `total_timeout` s, else Unreached.
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

        Never ends without an error: Silent after `total_timeout` s, counted from the first `next`,
        or Unreached.
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
        """Send a message of docs/protocol.md; raise Unreached if the console has gone."""
        assert self.socket is not None
        try:
            self.socket.sendall(encode(request))
        except OSError:
            raise Unreached(GONE) from None

    def close(self) -> None:
        if self.socket is not None:
            self.socket.close()

    def detach(self) -> tuple[socket.socket, bytes]:
        """Return the socket, which the caller closes, and the bytes that were not parsed."""
        assert self.socket is not None
        return self.socket, self._buffer

    def _next_message(self) -> dict[str, Any] | None:
        data, found, rest = self._buffer.partition(b"\n")
        if not found:
            return None
        self._buffer = rest
        return decode(data)


def _names_console(hello: dict[str, Any]) -> bool:
    texts = all(isinstance(hello.get(name), str) for name in ("robot", "namespace", "engine"))
    return texts and type(hello.get("pid")) is int
