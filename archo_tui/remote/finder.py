"""The search for the console that is meant, for shell, Python, assistant and `consoles`.

A verb goes to the only console that fits, and to none while another that could be meant does not
answer. A STOP goes to every console that could be meant: it is written as soon as the connection is
made, so that a busy or suspended console carries it out when it wakes.
"""

from __future__ import annotations

import os
import selectors
import socket
import time

from archo_tui.remote import socket_files
from archo_tui.remote.client import Connection, Unreached
from archo_tui.remote.protocol import GONE, LOST, NOT_MEANT, encode, is_meant

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

CHOSEN = "ARCHO_TUI_CONSOLE"  # The variable that stands for `--to`.
NO_CONSOLE = "no console runs here: start archo-tui, or archo-tui --plain"
HELLO_TIMEOUT = 1.0  # Seconds in which a console that runs takes a connection and says hello.
WAKE_TIMEOUT = 5.0  # Seconds that a STOP waits for the hello of a console.
STOP_TIMEOUT = 15.0  # Seconds: longer than any STOP takes in a console that runs.
_RETRY_PERIOD = 0.01  # Seconds between two tries to connect.
_POLL_PERIOD = 0.1  # Seconds between two looks at the time.
UNCONFIRMED = "not confirmed: the robot may be moving"


class NoConsole(Unreached):
    """The error for a search that found no console that could be meant."""


class StopResult:
    """The result of a STOP at one console."""

    def __init__(self, console: str, code: str, text: str) -> None:
        # code: of docs/protocol.md; LOST without a valid result
        self.console, self.code, self.text = console, code, text


def find(
    selection: Mapping[str, Any],
    faults: list[str] | None = None,
    hello_timeout: float = HELLO_TIMEOUT,
) -> list[Connection]:
    """Return connections to all consoles that could be meant, sorted by process number.

    Silent consoles are among them; the caller closes all. Socket files of killed consoles are
    removed, and reasons for unsearched folders are appended to `faults`.
    """
    found = _candidates(selection, [] if faults is None else faults)
    _exchange(found, b"", lambda console: bool(console.hello), hello_timeout)
    for console in found:
        if not _could_be_meant(selection, console):
            console.close()
    found = [
        console for console in found if not console.is_dead and _could_be_meant(selection, console)
    ]
    return sorted(found, key=lambda console: int(console.identity.get("pid", 0)))


def choose(selection: Mapping[str, Any], hello_timeout: float = HELLO_TIMEOUT) -> Connection:
    """Return a blocking connection to the one console that is meant; the caller closes it.

    A console that only watches is passed over if another one of the same robot acts. Raises
    NoConsole, or Unreached if several are meant or one does not answer: a verb could reach another
    robot.
    """
    selection, faults = _with_default_console(selection), []  # type: ignore[var-annotated]
    found = _without_needless_watchers(find(selection, faults, hello_timeout))
    silent = [console for console in found if console.fault]
    if len(found) == 1 and not silent:
        found[0].set_blocking()
        return found[0]
    for console in found:
        console.close()
    if silent:
        raise Unreached(_silent_error(selection, silent, found))
    if not found:
        raise NoConsole(no_console_error(selection, faults))
    raise Unreached(_several_error(selection, found))


def _without_needless_watchers(found: list[Connection]) -> list[Connection]:
    watching = _only_watching(found)
    for console in watching:
        console.close()
    return [console for console in found if console not in watching]


def _only_watching(found: Sequence[Connection]) -> list[Connection]:
    """Return the consoles that only watch a robot on which another one of `found` can act."""

    def robot(console: Connection) -> tuple[Any, ...]:
        return tuple(console.identity.get(name) for name in ("engine", "domain", "namespace"))

    watching = [console for console in found if console.identity.get("watching")]
    acting = {robot(c) for c in found if c.identity and c not in watching}
    return [console for console in watching if robot(console) in acting]


def reach(path: str, hello_timeout: float = HELLO_TIMEOUT) -> Connection:
    """Return a blocking connection to a socket's console after its hello; the caller closes it.

    Raises Unreached.
    """
    console = Connection(path, socket_files.read_card(path))
    _exchange([console], b"", lambda console: bool(console.hello), hello_timeout)
    if console.is_dead or console.fault:
        console.close()
        raise Unreached(GONE if console.is_dead or console.has_gone else console.fault)
    console.set_blocking()
    return console


def stop(
    selection: Mapping[str, Any],
    notice: Callable[[str], None],
    more: Mapping[str, Any] | None = None,
) -> list[StopResult]:
    """Send STOP to every console that could be meant, then wait for all of them, 15 s at most.

    If the console that ARCHO_TUI_CONSOLE names is not found, all others that fit get the STOP.
    Consoles that watch where another one acts have no result. Raises NoConsole.
    """
    faults: list[str] = []
    meant = _with_default_console(selection)
    ended = _stop_each(meant, notice, more or {}, faults)
    if not ended and not selection.get("to") and meant.get("to"):
        ended = _stop_each(selection, notice, more or {}, [])
        if ended:
            notice(f"no console {meant['to']} runs here, which {CHOSEN} names: STOP went to all")
    if not ended:
        raise NoConsole(no_console_error(meant, faults))
    for fault in faults:
        notice(fault)
    return ended


def _stop_each(
    selection: Mapping[str, Any],
    notice: Callable[[str], None],
    more: Mapping[str, Any],
    faults: list[str],
) -> list[StopResult]:
    found = _candidates(selection, faults)
    first = encode({"id": 1, "words": ["stop"], **more, **selection})
    began = time.monotonic()

    def is_over(console: Connection) -> bool:
        late = not console.hello and time.monotonic() > began + WAKE_TIMEOUT
        return console.result is not None or late

    _exchange(found, first, is_over, HELLO_TIMEOUT)
    for console in found:
        if not (console.hello or console.result or console.is_dead or console.has_gone):
            notice(f"{console.short_description} does not answer yet: STOP waits for it")
    _exchange(found, first, is_over, STOP_TIMEOUT - HELLO_TIMEOUT)
    there = [console for console in found if not console.is_dead]
    watching = _only_watching(there)  # Their refusal tells nothing about the robot.
    ended = [_stop_result(console) for console in there if console not in watching]
    for console in found:
        console.close()
    return [result for result in ended if result.code != NOT_MEANT]


def _stop_result(console: Connection) -> StopResult:
    result = console.result
    if result is not None:
        code, text = result["code"], result.get("text")
        is_text = isinstance(code, str) and isinstance(text, str)
        return StopResult(console.description, *((code, text) if is_text else (LOST, UNCONFIRMED)))
    why = "the console does not answer, and stops it when it does"
    if console.socket is None:
        why = "STOP could not be written to the console"
    elif console.has_gone:
        why = "the console is gone"
    return StopResult(console.description, LOST, f"{UNCONFIRMED}; {why}")


def _with_default_console(selection: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the selection; a missing `to` becomes ARCHO_TUI_CONSOLE's value."""
    to = selection.get("to") or os.environ.get(CHOSEN, "")
    return {**selection, "to": to} if to else dict(selection)


def _candidates(selection: Mapping[str, Any], faults: list[str]) -> list[Connection]:
    """Return an unconnected connection for each socket whose card does not exclude its console."""
    if not hasattr(socket, "AF_UNIX"):
        raise Unreached("this system has no sockets for it: only Linux and macOS do")
    paths = socket_files.socket_paths(faults)
    consoles = [Connection(path, socket_files.read_card(path)) for path in paths]
    return [console for console in consoles if _could_be_meant(selection, console)]


def _could_be_meant(selection: Mapping[str, Any], console: Connection) -> bool:
    """Return True unless hello or card exclude the console; with neither it could be meant."""
    return not console.identity or is_meant(selection, console.identity)


def _exchange(
    consoles: Sequence[Connection],
    first: bytes,
    is_over: Callable[[Connection], bool],
    timeout: float,
) -> None:
    """Connect to all and read until each `is_over`; errors are kept in the connections."""
    end = time.monotonic() + timeout
    while True:
        for console in consoles:
            if console.socket is None and not (console.is_dead or console.has_gone):
                console.connect(first)
        waiting = [
            console
            for console in consoles
            if not (console.is_dead or console.has_gone or is_over(console))
        ]
        left = end - time.monotonic()
        if not waiting or left <= 0:
            return
        is_refused = any(console.socket is None for console in waiting)
        left = min(left, _RETRY_PERIOD if is_refused else _POLL_PERIOD)
        # `select.select` takes no descriptor over 1023.
        with selectors.DefaultSelector() as selector:
            for console in waiting:
                if console.socket is not None:
                    selector.register(console.socket, selectors.EVENT_READ, console)
            if not selector.get_map():
                time.sleep(left)
            for key, _ in selector.select(left) if selector.get_map() else ():
                key.data.receive()


def _silent_error(
    selection: Mapping[str, Any], silent: Sequence[Connection], found: Sequence[Connection]
) -> str:
    faults = "; ".join(console.fault for console in silent)
    if selection.get("to"):
        return f"no console {selection['to']} answers here; {faults}"
    if len(found) == 1:
        return faults
    return (
        f"{faults}; nothing is chosen while it could be meant: --to PID or --to NAMESPACE chooses"
    )


def _several_error(selection: Mapping[str, Any], found: Sequence[Connection]) -> str:
    lines = "".join(f"\n  {console.description}" for console in found)
    if not selection.get("to"):
        return f"several consoles run here, --to PID or --to NAMESPACE chooses:{lines}"
    names = "".join(
        f"\n  --to {console.identity.get('name', '')}  {console.description}" for console in found
    )
    return (
        f"--to {selection['to']} fits several consoles, the names of their sockets choose:{names}"
    )


def no_console_error(selection: Mapping[str, Any], faults: Sequence[str]) -> str:
    """Return the error text for a search that found no console, with the likely causes."""
    to, by_name = selection.get("to", ""), os.environ.get(CHOSEN, "")
    text = NO_CONSOLE
    if to:
        named = f", which {CHOSEN} names" if to == by_name else ""
        text = f"no console {to} runs here{named} (archo-tui consoles lists them)"
    elif selection.get("engine"):
        domain = selection.get("domain")
        where = (
            selection["engine"] if domain is None else f"{selection['engine']}, domain {domain},"
        )
        text = f"no console of {where} runs here (archo-tui consoles lists them)"
    others = socket_files.other_users()
    hints = [*faults, *(f"a console of {user} runs here: run this as {user}" for user in others)]
    if os.environ.get(socket_files.FOLDER_VARIABLE):
        folder = socket_files.listening_folder()
        hints.append(f"{socket_files.FOLDER_VARIABLE} is set: only {folder} is looked into")
    return "; ".join((text, *hints))
