"""A connection to a console. Imports nothing but what every Python has, and little of that."""

from __future__ import annotations

import contextlib
import os
import time

from archo_tui.remote import place
from archo_tui.remote.protocol import GONE, PROTOCOL, line, message

TYPE_CHECKING = False
if TYPE_CHECKING:
    import socket
    from collections.abc import Iterator
    from typing import Any

_MUTE = "the console does not answer"
UNANSWERED = "the console does not answer; the robot may still be moving"


class Unreached(Exception):
    """No console, or several."""


class Silent(Unreached):
    """The console said nothing for as long as it was waited for."""


class Connection:
    """One console: first it is connected to without waiting, later requests wait for it."""

    def __init__(self, path: str, card: dict[str, Any] | None = None) -> None:
        """Connects to nobody yet.

        Args:
            path: Its socket's.
            card: What the console has left beside the socket; None where it has not.
        """
        self.path, self.card = path, card
        self.hello: dict[str, Any] = {}  # empty: it has not said one
        self.result: dict[str, Any] | None = None  # of what was sent as it was connected to
        self.is_dead = False  # nobody listens
        self.has_gone = False  # it was connected, and is no more
        self.socket: socket.socket | None = None
        self._rest = b""
        self._number = 0

    # without waiting: `finder.py`

    def connect(self, first: bytes) -> None:
        """Try to connect, and then send a line before anything is said."""
        try:
            self.socket = place.connect(self.path)
            if first:
                self.socket.send(first)  # fits: nothing else waits to be read
        except BlockingIOError:  # too many wait to be taken: the next look tries again
            pass
        except (ConnectionRefusedError, FileNotFoundError) as error:
            self.is_dead = True
            if isinstance(error, ConnectionRefusedError):  # its console was killed
                place.forget(self.path)
        except OSError:
            self.has_gone = True

    def read(self) -> None:
        """Take what has come; the socket is ready."""
        assert self.socket is not None
        try:
            chunk = self.socket.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        self._rest += chunk
        try:
            while not self.result and (said := self._cut()) is not None:
                if "code" in said:
                    self.result = said
                elif not self.hello:
                    self.hello = said
        except ValueError:
            chunk = b""
        self.has_gone = self.has_gone or not chunk

    @property
    def fault(self) -> str:
        """Why no verb can be sent to it; an empty string when one can."""
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
        pid = os.path.basename(self.path).partition(place.SUFFIX)[0].partition("-")[0]
        return f"the console of pid {pid}"

    @property
    def who(self) -> dict[str, Any]:
        """What it says of itself, or has said on its card; empty: neither."""
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

    # waiting

    def wait(self) -> None:
        """Let what follows wait for it; a hello is there."""
        assert self.socket is not None
        self.socket.settimeout(None)

    def request(self, within: float | None = None, **asked: Any) -> Iterator[dict[str, Any]]:
        """Send it; yields all that is said to it, the result last.

        Args:
            within: How many seconds all of it may take; None: any.
            asked: What a request has (docs/protocol.md).

        Raises Unreached.
        """
        self._number += 1
        number = self._number
        self.send({"id": number, **asked})
        for said in self.rest(within):
            if said.get("id") in (number, None):
                yield said
                if "code" in said:
                    return

    def rest(self, within: float | None = None) -> Iterator[dict[str, Any]]:
        """Yield what else is said. Raises Unreached at its end, Silent after `within` seconds."""
        assert self.socket is not None
        end = None if within is None else time.monotonic() + within
        try:
            while True:
                while (said := self._cut()) is not None:
                    yield said
                self.socket.settimeout(None if end is None else max(end - time.monotonic(), 0.001))
                chunk = self.socket.recv(65536)
                if not chunk:
                    break
                self._rest += chunk
        except TimeoutError:
            raise Silent(UNANSWERED) from None
        except (OSError, ValueError):  # as if it had ended
            pass
        finally:
            with contextlib.suppress(OSError):
                self.socket.settimeout(None)
        raise Unreached(GONE)

    def send(self, said: dict[str, Any]) -> None:
        """Say something more to what is being carried out. Raises Unreached."""
        assert self.socket is not None
        try:
            self.socket.sendall(line(said))
        except OSError:
            raise Unreached(GONE) from None

    def close(self) -> None:
        """Leave."""
        if self.socket is not None:
            self.socket.close()

    def handed_over(self) -> tuple[socket.socket, bytes]:
        """The socket, for a caller that reads it otherwise, and what was read of it already."""
        assert self.socket is not None
        return self.socket, self._rest

    def _cut(self) -> dict[str, Any] | None:
        """The next message of what was read; None: there is no whole one. Raises ValueError."""
        data, found, rest = self._rest.partition(b"\n")
        if not found:
            return None
        self._rest = rest
        return message(data)


def _is_whole(hello: dict[str, Any]) -> bool:
    """True when it has what a console is called by."""
    texts = all(isinstance(hello.get(name), str) for name in ("robot", "namespace", "engine"))
    return texts and type(hello.get("pid")) is int
