"""A connection to a console's socket. Imports little, and only of the standard library."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import time

from archo_tui.client import sockets
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import GONE, LONGEST_WAIT, PROTOCOL, decode, encode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any

_MAY_MOVE = "the robot may still be moving"
UNANSWERED = f"the console does not answer; {_MAY_MOVE}"
UNCONFIRMED = "not confirmed: the robot may be moving"
HELLO_TIMEOUT = 1.0  # Seconds in which a console that runs takes a connection and says hello.
# Seconds without a message after which the console is asked whether it still answers.
_SILENCE = 10.0
_SEND_TIMEOUT = 15.0  # Seconds that a suspended console, which reads nothing, may hold a message.
_LONGEST_LINE = 1 << 26  # Bytes of a message; a whole point cloud as JSON is shorter.
# Seconds behind a `timeout` for the result: a console calls off for 3 s, and reports it then.
_CALL_OFF_TIMEOUT = 5.0


class Silent(Unreached):
    """The error for a console that did not send what was waited for in time."""


def _unix_socket() -> socket.socket:
    if sys.platform == "win32":  # Nobody listens there: see `find`.
        raise OSError("Windows has no such sockets")
    return socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)


class Connection:
    """A connection to one console, which its card describes also while it does not answer."""

    def __init__(self, path: str, connected: socket.socket | None = None) -> None:
        """Create a connection; one that is not `connected` yet is to the socket at `path`."""
        self.path, self.card = path, {} if connected else sockets.read_card(path)
        self._buffer = b""
        self._number = 0
        self.socket = connected or _unix_socket()
        _sockets.add(self.socket)
        self.socket.setblocking(False)

    def connect(self) -> bool:
        """Connect without waiting; False while too many others wait for the console.

        Raises OSError if there is none; the files of a console that was killed are removed.
        """
        try:
            self.socket.connect(self.path)
        except BlockingIOError:
            return False
        except OSError as error:
            self.close()
            if isinstance(error, ConnectionRefusedError):
                sockets.remove(self.path)
            raise
        return True

    @property
    def short_description(self) -> str:
        """The words `the console of pid N, NAMESPACE,`; without a card only the pid."""
        if self.card:
            return f"the console of pid {self.card['pid']}, {self.card['namespace']},"
        return f"the console of {self.description}"

    @property
    def description(self) -> str:
        """The console in a line: `pid 7: ROBOT NAMESPACE, ENGINE domain 0`, with `, watching`."""
        card = self.card
        if not card:
            name = os.path.basename(self.path).removesuffix(sockets.SUFFIX)
            return f"pid {name.partition('-')[0]}"
        domain = "" if card.get("domain") is None else f" domain {card['domain']}"
        where = f"{card['robot']} {card['namespace']}, {card['engine']}{domain}"
        return f"pid {card['pid']}: {where}{', watching' if card.get('watching') else ''}"

    def fault(self, timeout: float) -> str:
        """Read the hello, and return why this console takes no verb; "" if it takes verbs."""
        try:
            hello = next(self.replies(timeout))
        except Silent:
            return f"{self.short_description} does not answer: is it suspended?"
        except Unreached:
            return f"{self.short_description} does not answer"
        if hello.get("protocol") != PROTOCOL:
            return (
                f"{self.short_description} speaks protocol {hello.get('protocol')}, "
                f"this archo-tui {PROTOCOL}: use the same version of both"
            )
        return "" if self.card else f"{self.short_description} does not say which robot it operates"

    def request(self, timeout: float | None = None, /, **fields: Any) -> Iterator[dict[str, Any]]:
        """Send a request, which may take `timeout` s, and yield all replies to it, the result last.

        After each 10 s without a reply, another connection tests whether the console still answers.
        """
        self._number += 1
        self.send({"id": self._number, "timeout": timeout, **fields})
        end = None if timeout is None else time.monotonic() + timeout + _CALL_OFF_TIMEOUT
        return self._replies_to(self._number, end)

    def result(self, timeout: float | None = None, /, **fields: Any) -> dict[str, Any]:
        """Send a request, and return its result; other replies are dropped."""
        *_, result = self.request(timeout, **fields)
        return result

    def answer(self, timeout: float, /, **fields: Any) -> dict[str, Any]:
        """Send a request, and return its result; Silent if it does not come within `timeout` s."""
        self._number += 1
        self.send({"id": self._number, **fields})
        return next(
            reply
            for reply in self.replies(timeout)
            if reply.get("id") == self._number and is_result(reply)
        )

    def _replies_to(self, number: int, end: float | None) -> Iterator[dict[str, Any]]:
        reply: dict[str, Any] = {}
        while "code" not in reply:
            left = LONGEST_WAIT if end is None else end - time.monotonic()
            try:
                reply = next(self.replies(min(max(left, 0.0), _SILENCE)))
            except Silent:
                if left <= _SILENCE:
                    raise
                if self.path:
                    self._test_answering()
                continue
            if reply.get("id") in (number, None) and "protocol" not in reply:
                if "code" in reply and not is_result(reply):
                    raise Unreached(GONE)  # What is broken counts as ended, as in `replies`.
                yield reply
            else:
                reply = {}

    def _test_answering(self) -> None:
        """Raise Unreached, with what may be of the robot, if no other connection is answered."""
        try:
            reach(self.path, _SILENCE).close()
        except Unreached as error:
            text = str(error)
            raise Unreached(text if text == GONE else f"{_MAY_MOVE}: {text}") from None

    def replies(self, timeout: float | None = None) -> Iterator[dict[str, Any]]:
        """Yield all further messages of the console, whichever request they are for.

        Beats are answered, by which the console knows that this process is not suspended.
        Never ends without an error: Silent after `timeout` s, counted from the first `next`, or
        Unreached.
        """
        end = None if timeout is None else time.monotonic() + timeout
        try:
            while True:
                data, found, rest = self._buffer.partition(b"\n")
                if found:
                    self._buffer = rest
                    message = decode(data)
                    if "beat" in message:
                        self.send({"beat": True})
                    else:
                        yield message
                    continue
                self.socket.settimeout(None if end is None else max(end - time.monotonic(), 0.001))
                chunk = self.socket.recv(65536)
                if not chunk:
                    break
                self._buffer += chunk
                if len(self._buffer) > _LONGEST_LINE and b"\n" not in chunk:
                    break
                if end is not None and time.monotonic() > end and b"\n" not in chunk:
                    raise TimeoutError
        except TimeoutError:
            raise Silent(UNANSWERED) from None
        except (OSError, ValueError):  # A broken connection counts as an ended one.
            pass
        raise Unreached(GONE)

    def send(self, message: dict[str, Any]) -> None:
        """Send a message of docs/protocol.md; raise Unreached if the console has gone."""
        try:
            self.socket.settimeout(_SEND_TIMEOUT)
            self.socket.sendall(encode(message))
        except OSError:
            raise Unreached(GONE) from None

    @property
    def has_ended(self) -> bool:
        """True if the console has closed the connection, and nothing of it is left to read."""
        try:
            self.socket.setblocking(False)
            return not self.socket.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return False
        except OSError:
            return True

    def give_up(self) -> None:
        """Call the request off, without waiting; a broken connection is no error."""
        with contextlib.suppress(Unreached):
            self.send({"give_up": True})

    def shut_down(self) -> None:
        """End the connection from another thread: `replies` raises Unreached."""
        with contextlib.suppress(OSError):  # It is closed already.
            self.socket.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the connection: the console calls off what is still underway."""
        _sockets.discard(self.socket)
        self.socket.close()

    def __enter__(self) -> Connection:
        return self

    def __exit__(self, kind: object, error: BaseException | None, at: object) -> None:
        if error is not None:
            self.give_up()
        self.close()

    def __del__(self) -> None:
        with contextlib.suppress(AttributeError):  # It was never made.
            self.close()  # An iterator over events was never begun.


_sockets: set[socket.socket] = set()  # Of the connections that are not closed.


def close_all() -> None:
    """Close the copies that a forked child has of its parent's connections.

    Else the console would not notice the end of the parent, and let its goals run on.
    """
    for copy in list(_sockets):
        copy.close()
    _sockets.clear()


def is_result(reply: dict[str, Any]) -> bool:
    """Return True for the last reply to a request, which has a code and a text."""
    return isinstance(reply.get("code"), str) and isinstance(reply.get("text"), str)


def reach(path: str, hello_timeout: float = HELLO_TIMEOUT) -> Connection:
    """Return a connection to a socket's console after its hello; raise Unreached."""
    console = Connection(path)
    try:
        is_connected = console.connect()
    except OSError:
        raise Unreached(GONE) from None
    fault = console.fault(hello_timeout) if is_connected else UNCONFIRMED
    if fault:
        console.close()
        raise Unreached(fault)
    return console
