"""A connection to a console's socket. Imports little, and only of the standard library."""

from __future__ import annotations

import contextlib
import os
import time

from archo_tui.remote import socket_files
from archo_tui.remote.protocol import GONE, PROTOCOL, line, message

TYPE_CHECKING = False
if TYPE_CHECKING:
    import socket
    from collections.abc import Iterator
    from typing import Any

_MUTE = "the console does not answer"
UNANSWERED = "the console does not answer; the robot may still be moving"


class Unreached(Exception):
    """No console is reached: none runs, several do, or it does not answer."""


class Silent(Unreached):
    """The console sent nothing within the time that it was waited for."""


class Connection:
    """A connection to one console: made without waiting, then used for requests that wait.

    Attributes:
        path: The socket.
        card: What the console has left beside the socket; None: nothing.
        hello: Its first message; empty: it has not come.
        result: The result of the line that was sent on connecting; None: it has not come.
        is_dead: True if nobody listens.
        has_gone: True if it was connected, and is no more.
        socket: The connected socket; None before that.
    """

    def __init__(self, path: str, card: dict[str, Any] | None = None) -> None:
        """Make it without connecting."""
        self.path, self.card = path, card
        self.hello: dict[str, Any] = {}
        self.result: dict[str, Any] | None = None
        self.is_dead = False
        self.has_gone = False
        self.socket: socket.socket | None = None
        self._rest = b""
        self._number = 0

    # Without waiting: see `finder.py`.

    def connect(self, first: bytes) -> None:
        """Try to connect, and send the bytes `first` before the hello has come."""
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

    def read(self) -> None:
        """Read what has come; the socket must be ready."""
        assert self.socket is not None
        try:
            chunk = self.socket.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        self._rest += chunk
        try:
            while not self.result and (said := self._next_message()) is not None:
                if "code" in said:
                    self.result = said
                elif not self.hello:
                    self.hello = said
        except ValueError:
            chunk = b""
        self.has_gone = self.has_gone or not chunk

    @property
    def fault(self) -> str:
        """The reason why no verb can be sent to this console; "" if one can."""
        if not self.hello:
            return f"{self.called} does not answer: is it suspended?"
        spoken = self.hello.get("protocol")
        if spoken != PROTOCOL:
            return (
                f"the console of pid {self.hello.get('pid')} speaks protocol {spoken}, "
                f"this archo-tui {PROTOCOL}: use the same version of both"
            )
        return "" if _is_whole(self.hello) and not self.has_gone else _MUTE

    @property
    def called(self) -> str:
        """The console in a few words, also while it is silent."""
        if self.who:
            return f"the console of pid {self.who['pid']}, {self.who['namespace']},"
        pid = os.path.basename(self.path).partition(socket_files.SUFFIX)[0].partition("-")[0]
        return f"the console of pid {pid}"

    @property
    def who(self) -> dict[str, Any]:
        """The robot, namespace, engine and pid of the console, among other values.

        They are those of its hello or, until a valid one has come, those of its card: the file
        beside the socket with a copy of the hello. Empty if neither names the console.
        """
        return next((one for one in (self.hello, self.card) if one and _is_whole(one)), {})

    @property
    def described(self) -> str:
        """The console in a line: process, robot, namespace, engine."""
        who = self.who
        if not who:
            return self.called.removeprefix("the console of ")
        domain = "" if who.get("domain") is None else f" domain {who['domain']}"
        where = f"{who['robot']} {who['namespace']}, {who['engine']}{domain}"
        return f"pid {who['pid']}: {where}{', watching' if who.get('watching') else ''}"

    # Waiting, once the hello has come.

    def wait(self) -> None:
        """Let the calls that follow wait for the console."""
        assert self.socket is not None
        self.socket.settimeout(None)

    def request(self, within: float | None = None, **asked: Any) -> Iterator[dict[str, Any]]:
        """Send a request, and yield all replies to it, the result last.

        Args:
            within: Seconds that all of it may take; None: any time.
            asked: The request, as docs/protocol.md lists its names and values.

        Raises:
            Unreached: The console has gone, or did not answer in time.
        """
        self._number += 1
        number = self._number
        self.send({"id": number, **asked})
        for said in self.remaining_replies(within):
            if said.get("id") in (number, None):
                yield said
                if "code" in said:
                    return

    def remaining_replies(self, within: float | None = None) -> Iterator[dict[str, Any]]:
        """Yield every further message of the console, whichever request it is for.

        Args:
            within: Seconds after which `Silent` is raised; None: it waits for any time.

        Raises:
            Silent: The time is over.
            Unreached: The console has gone.
        """
        assert self.socket is not None
        end = None if within is None else time.monotonic() + within
        try:
            while True:
                while (said := self._next_message()) is not None:
                    yield said
                self.socket.settimeout(None if end is None else max(end - time.monotonic(), 0.001))
                chunk = self.socket.recv(65536)
                if not chunk:
                    break
                self._rest += chunk
        except TimeoutError:
            raise Silent(UNANSWERED) from None
        except (OSError, ValueError):  # A broken connection counts as an ended one.
            pass
        finally:
            with contextlib.suppress(OSError):
                self.socket.settimeout(None)
        raise Unreached(GONE)

    def send(self, said: dict[str, Any]) -> None:
        """Send a message.

        Raises:
            Unreached: The console has gone.
        """
        assert self.socket is not None
        try:
            self.socket.sendall(line(said))
        except OSError:
            raise Unreached(GONE) from None

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self.socket is not None:
            self.socket.close()

    def handed_over(self) -> tuple[socket.socket, bytes]:
        """Return the socket, for a caller that reads it by itself, and the unused bytes of it."""
        assert self.socket is not None
        return self.socket, self._rest

    def _next_message(self) -> dict[str, Any] | None:
        """Take the next message out of what was read.

        Returns:
            None if there is no whole one.

        Raises:
            ValueError: It is no JSON object.
        """
        data, found, rest = self._rest.partition(b"\n")
        if not found:
            return None
        self._rest = rest
        return message(data)


def _is_whole(hello: dict[str, Any]) -> bool:
    """Return True if a hello has the values that name a console."""
    texts = all(isinstance(hello.get(name), str) for name in ("robot", "namespace", "engine"))
    return texts and type(hello.get("pid")) is int
