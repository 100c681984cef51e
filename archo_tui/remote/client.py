"""A connection to a console. Imports nothing but what every Python has, and little of that."""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import time

from archo_tui.remote import place
from archo_tui.remote.protocol import GONE, PROTOCOL, line, message

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from typing import Any

CHOSEN = "ARCHO_TUI_CONSOLE"  # the environment's word for `--to`
NOBODY = "no console runs here: start archo-tui, or archo-tui --plain"
_MUTE = "the console does not answer"
UNANSWERED = "the console does not answer; the robot may still be moving"


class Unreached(Exception):
    """No console, or several."""


class Connection:
    """One console that listens, from its hello on."""

    def __init__(self, connected: socket.socket) -> None:
        """Raises Unreached when it says nothing, or speaks another protocol."""
        self._socket, self._rest = connected, b""
        self._number = 0
        try:
            self.hello = next(self._messages())
        except (StopIteration, OSError, ValueError):
            connected.close()
            raise Unreached(_MUTE) from None
        spoken = self.hello.get("protocol")
        if spoken != PROTOCOL:
            connected.close()
            raise Unreached(
                f"the console of pid {self.hello.get('pid')} speaks protocol {spoken}, "
                f"this archo-tui {PROTOCOL}: use the same version of both"
            )
        if not _is_whole(self.hello):
            connected.close()
            raise Unreached(_MUTE)
        connected.settimeout(None)

    def request(self, **asked: Any) -> Iterator[dict[str, Any]]:
        """Send it; yields all that is said to it, the result last. Raises Unreached."""
        self._number += 1
        number = self._number
        self.send({"id": number, **asked})
        try:
            for said in self._messages():
                if said.get("id") in (number, None):
                    yield said
                    if "code" in said:
                        return
        except (OSError, ValueError):
            pass
        raise Unreached(GONE)

    def rest(self, within: float | None = None) -> Iterator[dict[str, Any]]:
        """What else is said. Raises Unreached when nothing is, for so many s."""
        try:
            self._socket.settimeout(within)
            yield from self._messages()
        except TimeoutError:
            raise Unreached(UNANSWERED) from None
        except (OSError, ValueError):  # as if it had ended
            pass
        finally:
            with contextlib.suppress(OSError):
                self._socket.settimeout(None)
        raise Unreached(GONE)

    def send(self, said: dict[str, Any]) -> None:
        """Say something more to what is being carried out. Raises Unreached."""
        try:
            self._socket.sendall(line(said))
        except OSError:
            raise Unreached(GONE) from None

    def close(self) -> None:
        """Leave."""
        self._socket.close()

    def handed_over(self) -> tuple[socket.socket, bytes]:
        """The socket, for a caller that reads it otherwise, and what was read of it already."""
        return self._socket, self._rest

    def _messages(self) -> Iterator[dict[str, Any]]:
        while True:
            data, found, rest = self._rest.partition(b"\n")
            if found:
                self._rest = rest
                yield message(data)
                continue
            chunk = self._socket.recv(65536)
            if not chunk:
                return
            self._rest += chunk


def _is_whole(hello: dict[str, Any]) -> bool:
    """True when it has what a console is called by."""
    texts = all(isinstance(hello.get(name), str) for name in ("robot", "namespace", "engine"))
    return texts and type(hello.get("pid")) is int


def greeted(faults: list[str]) -> Iterator[Connection]:
    """Those that run here, each as soon as it says hello; `faults` is told why others do not."""
    if not hasattr(socket, "AF_UNIX"):
        raise Unreached("this system has no sockets for it: only Linux and macOS do")
    fault = place.fault(place.folder()) if os.path.lexists(place.folder()) else ""
    if fault:  # somebody else could listen there
        faults.append(fault)
        return
    waiting = {}
    for name in place.sockets():
        connected = place.reached(name)
        if connected is not None:
            waiting[connected] = name
    end = time.monotonic() + place.SOON
    while waiting:
        ready = _ready([*waiting], end - time.monotonic())
        for connected in ready or [*waiting]:
            name = waiting.pop(connected)
            if not ready:
                connected.close()
                pid = name[: -len(place.SUFFIX)]
                faults.append(f"the console of pid {pid} does not answer: is it suspended?")
                continue
            try:
                yield Connection(connected)
            except Unreached as error:
                faults.append(str(error))


def _ready(waiting: list[socket.socket], seconds: float) -> list[Any]:
    """Those of them that have said something by then."""
    with selectors.DefaultSelector() as selector:  # select.select takes no descriptor above 1023
        for one in waiting:
            selector.register(one, selectors.EVENT_READ)
        return [key.fileobj for key, _ in selector.select(max(seconds, 0.0))]


def consoles(faults: list[str] | None = None) -> list[Connection]:
    """All that run here, by their numbers; `faults` is told why others cannot be spoken to.

    Raises Unreached when all of them cannot.
    """
    faults = [] if faults is None else faults
    found = sorted(greeted(faults), key=lambda console: int(console.hello["pid"]))
    if faults and not found:
        raise Unreached(faults[0])
    return found


def described(connection: Connection) -> str:
    """A console in a line."""
    hello = connection.hello
    where = f"{hello['robot']} {hello['namespace']}, {hello['engine']}"
    return f"pid {hello['pid']}: {where}{', watching' if hello.get('watching') else ''}"


def fits(console: Connection, to: str) -> bool:
    """True for the one that is meant; any is, where none was chosen."""
    to = to or os.environ.get(CHOSEN, "")
    return not to or to in (str(console.hello["pid"]), console.hello["namespace"])


def chosen(to: str = "") -> list[Connection]:
    """Those that fit: of that number or namespace, or all. Raises Unreached when none does."""
    faults: list[str] = []
    found = consoles(faults)
    fitting = [console for console in found if fits(console, to)]
    for other in found:
        if other not in fitting:
            other.close()
    if not fitting:
        raise Unreached(nobody(to, faults))
    return fitting


def nobody(to: str, faults: Sequence[str]) -> str:
    """That none fits; one that cannot be spoken to may be the one that was meant."""
    to = to or os.environ.get(CHOSEN, "")
    if faults:
        return f"no console {to} answers here; {faults[0]}" if to else faults[0]
    return f"no console {to} runs here (archo-tui consoles lists them)" if to else NOBODY


def one(to: str = "") -> Connection:
    """The one that fits. Raises Unreached when there is none, or when there are several."""
    fitting = chosen(to)
    if len(fitting) > 1:
        lines = "".join(f"\n  {described(console)}" for console in fitting)
        for console in fitting:
            console.close()
        raise Unreached(f"several consoles run here, --to PID or --to NAMESPACE chooses:{lines}")
    return fitting[0]
