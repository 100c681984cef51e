"""The search for the console that is meant, for shell, Python, assistant and `consoles`.

A verb goes to the only console that fits, and to none while another that could be meant does not
answer. A STOP goes to every console that could be meant: it is written as soon as the connection is
made, so that a busy or suspended console carries it out when it wakes.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time

from archo_tui.client import sockets
from archo_tui.client.connection import HELLO_TIMEOUT, UNCONFIRMED, Connection, Silent
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import LOST

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

CHOSEN = "ARCHO_TUI_CONSOLE"  # The variable that stands for `--to`.
NO_CONSOLE = "no console runs here: start archo-tui, or archo-tui --plain"
WAKE_TIMEOUT = 5.0  # Seconds that a STOP waits for the hello of a console.
STOP_TIMEOUT = 15.0  # Seconds: longer than any STOP takes in a console that runs.
_RETRY_PERIOD = 0.01  # Seconds between two tries to connect.


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
    first: dict[str, Any] | None = None,
) -> list[Connection]:
    """Return connections to all consoles that could be meant, sorted by process number.

    `first` is sent to each as soon as it is connected. The caller closes all. The reason why the
    folder is not searched goes into `faults`.
    """
    if not hasattr(socket, "AF_UNIX"):
        raise Unreached("this system has no sockets for it: only Linux and macOS do")
    paths = sockets.socket_paths(faults)
    found = [Connection(p) for p in paths if _could_be_meant(selection, sockets.read_card(p))]
    waiting, end = [*found], time.monotonic() + HELLO_TIMEOUT
    while waiting:
        for console in [*waiting]:
            try:
                is_connected = console.connect()
            except OSError:  # It is dead.
                waiting.remove(console)
                found.remove(console)
                continue
            if is_connected:
                waiting.remove(console)
                if first is not None:
                    with contextlib.suppress(Unreached):  # Whoever reads the result sees it.
                        console.send(first)
        if time.monotonic() > end:  # These do not answer.
            break
        if waiting:
            time.sleep(_RETRY_PERIOD)
    return sorted(found, key=lambda console: int(console.card.get("pid", 0)))


def choose(selection: Mapping[str, Any], hello_timeout: float | None = None) -> Connection:
    """Return a connection to the one console that is meant; the caller closes it.

    A console that only watches is passed over if another one of the same robot acts. Raises
    NoConsole, or Unreached if several are meant or one does not answer: a verb could reach another
    robot.
    """
    selection, faults = _with_default_console(selection), []  # type: ignore[var-annotated]
    found = find(selection, faults)
    for console in _only_watching(found):
        found.remove(console)
        console.close()
    end = time.monotonic() + (HELLO_TIMEOUT if hello_timeout is None else hello_timeout)
    silent = [fault for c in found if (fault := c.fault(max(end - time.monotonic(), 0.01)))]
    if len(found) == 1 and not silent:
        return found[0]
    for console in found:
        console.close()
    if silent:
        raise Unreached(_silent_error(selection, silent, len(found)))
    if not found:
        raise NoConsole(no_console_error(selection, faults))
    raise Unreached(_several_error(selection, found))


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
    meant, request = _with_default_console(selection), {"id": 1, "words": ["stop"], **(more or {})}
    began = time.monotonic()
    found = find(meant, faults, request)
    if not found and not selection.get("to") and meant.get("to"):
        found = find(selection, [], request)
        if found:
            notice(f"no console {meant['to']} runs here, which {CHOSEN} names: STOP went to all")
    if not found:
        raise NoConsole(no_console_error(meant, faults))
    for fault in faults:
        notice(fault)
    watching = _only_watching(found)  # Their refusal tells nothing about the robot.
    ended = [_stop_result(console, began, notice) for console in found if console not in watching]
    for console in found:
        console.close()
    return ended


def _stop_result(console: Connection, began: float, notice: Callable[[str], None]) -> StopResult:
    """Wait for the result of a STOP that was written at `began`."""
    is_greeted, why = False, "the console does not answer, and stops it when it does"
    for limit in (HELLO_TIMEOUT, WAKE_TIMEOUT, STOP_TIMEOUT):
        try:
            for reply in console.replies(max(began + limit - time.monotonic(), 0.01)):
                is_greeted = True
                code, text = reply.get("code"), reply.get("text")
                if isinstance(code, str) and isinstance(text, str):
                    return StopResult(console.description, code, text)
        except Silent:
            if limit == HELLO_TIMEOUT and not is_greeted:
                notice(f"{console.short_description} does not answer yet: STOP waits for it")
            if limit == WAKE_TIMEOUT and not is_greeted:
                break
        except Unreached:
            why = "the console is gone, or takes no connection"
            break
    return StopResult(console.description, LOST, f"{UNCONFIRMED}; {why}")


def _could_be_meant(selection: Mapping[str, Any], card: Mapping[str, Any]) -> bool:
    """Return True if a console fits `to`, `engine` and `domain`; one that is missing fits all.

    `to` is a process number, a namespace or a socket's name. A console without a domain fits every
    domain, and one without a card could be meant by anything.
    """
    if not card:
        return True
    to, engine, domain = selection.get("to"), selection.get("engine"), selection.get("domain")
    return (
        (not to or str(to) in (str(card["pid"]), card["namespace"], card["name"]))
        and (not engine or engine == card["engine"])
        and (domain is None or card.get("domain") in (None, domain))
    )


def _only_watching(found: Sequence[Connection]) -> list[Connection]:
    """Return the consoles that only watch a robot on which another one of `found` can act."""

    def robot(console: Connection) -> tuple[Any, ...]:
        return tuple(console.card.get(name) for name in ("engine", "domain", "namespace"))

    acting = {robot(c) for c in found if c.card and not c.card.get("watching")}
    return [c for c in found if c.card.get("watching") and robot(c) in acting]


def _with_default_console(selection: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the selection; a missing `to` becomes ARCHO_TUI_CONSOLE's value."""
    to = selection.get("to") or os.environ.get(CHOSEN, "")
    return {**selection, "to": to} if to else dict(selection)


def _silent_error(selection: Mapping[str, Any], silent: Sequence[str], count: int) -> str:
    faults = "; ".join(silent)
    if selection.get("to"):
        return f"no console {selection['to']} answers here; {faults}"
    if count == 1:
        return faults
    return (
        f"{faults}; nothing is chosen while it could be meant: --to PID or --to NAMESPACE chooses"
    )


def _several_error(selection: Mapping[str, Any], found: Sequence[Connection]) -> str:
    to = selection.get("to")
    if not to:
        lines = "".join(f"\n  {console.description}" for console in found)
        return f"several consoles run here, --to PID or --to NAMESPACE chooses:{lines}"
    lines = "".join(f"\n  --to {c.card['name']}  {c.description}" for c in found)
    return f"--to {to} fits several consoles, the names of their sockets choose:{lines}"


def no_console_error(selection: Mapping[str, Any], faults: Sequence[str]) -> str:
    """Return the error text for a search that found no console, with the likely causes."""
    to, engine, domain = (selection.get(name) for name in ("to", "engine", "domain"))
    text = NO_CONSOLE
    if to:
        named = f", which {CHOSEN} names" if to == os.environ.get(CHOSEN, "") else ""
        text = f"no console {to} runs here{named} (archo-tui consoles lists them)"
    elif engine:
        where = engine if domain is None else f"{engine}, domain {domain},"
        text = f"no console of {where} runs here (archo-tui consoles lists them)"
    others = sockets.other_users()
    hints = [*faults, *(f"a console of {user} runs here: run this as {user}" for user in others)]
    if os.environ.get(sockets.FOLDER_VARIABLE):
        hints.append(f"{sockets.FOLDER_VARIABLE} is set: only {sockets.folder()} is looked into")
    return "; ".join((text, *hints))
