"""Which console is meant: the one search that shell, Python, assistant and `consoles` go by.

A verb goes to the only console that fits, and to none while one that could be meant does not
answer. A STOP goes to every console that could be meant: it is written as each is connected to,
so that one that is busy or suspended carries it out when it wakes.
"""

from __future__ import annotations

import os
import selectors
import socket
import time

from archo_tui.remote import place
from archo_tui.remote.client import Connection, Unreached
from archo_tui.remote.protocol import GONE, LOST, NOT_MEANT, is_meant, line

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

CHOSEN = "ARCHO_TUI_CONSOLE"  # the environment's word for `--to`
NOBODY = "no console runs here: start archo-tui, or archo-tui --plain"
SOON = 1.0  # s in which a console that lives takes a connection, and says hello
WAKES = 5.0  # s in which a STOP waits for a console that says nothing
ANSWERS = 15.0  # s: longer than any STOP is waited for in a console that lives
_AGAIN = 0.01  # s between two tries to connect
_LOOK = 0.1  # s between two looks whether any was waited for long enough
UNCONFIRMED = "not confirmed: the robot may be moving"


class Nobody(Unreached):
    """No console could be meant."""


class Stopped:
    """How a STOP ended at one console."""

    def __init__(self, console: str, code: str, text: str) -> None:
        self.console, self.code, self.text = console, code, text


def find(asked: Mapping[str, Any], faults: list[str] | None = None) -> list[Connection]:
    """Return all that could be meant, those that do not answer too, by their processes.

    Args:
        asked: `to`, `engine` and `domain`, as `protocol.is_meant` takes them.
        faults: Is told why folders are not looked into.
    """
    found = _candidates(asked, [] if faults is None else faults)
    _exchange(found, b"", lambda console: bool(console.hello), SOON)
    for console in found:
        if not _could(asked, console):
            console.close()
    found = [one for one in found if not one.is_dead and _could(asked, one)]
    return sorted(found, key=lambda console: int(console.who.get("pid", 0)))


def choose(asked: Mapping[str, Any]) -> Connection:
    """Return the one console that is meant, which has said hello.

    A console that only watches is passed over where another one of the same robot can act. Raises
    Unreached when there is none, when there are several, and while one that could be meant does
    not answer: else a verb would drive another robot.
    """
    asked, faults = _with_variable(asked), []  # type: ignore[var-annotated]
    found = _able_to_act(find(asked, faults))
    silent = [console for console in found if console.fault]
    if len(found) == 1 and not silent:
        found[0].wait()
        return found[0]
    for console in found:
        console.close()
    if silent:
        raise Unreached(_silent(asked, silent, found))
    if not found:
        raise Nobody(nobody(asked, faults))
    raise Unreached(_several(asked, found))


def _able_to_act(found: list[Connection]) -> list[Connection]:
    """Return the consoles without those that watch a robot on which another one can act.

    The others are closed. A robot is told by its engine, domain and namespace.
    """

    def robot(console: Connection) -> tuple[Any, ...]:
        return tuple(console.who.get(name) for name in ("engine", "domain", "namespace"))

    acting = {robot(one) for one in found if one.who and not one.who.get("watching")}
    chosen = [one for one in found if not (one.who.get("watching") and robot(one) in acting)]
    for console in found:
        if console not in chosen:
            console.close()
    return chosen


def reach(path: str, within: float = SOON) -> Connection:
    """Return a further connection to a console that was chosen before.

    Args:
        path: Its socket.
        within: Seconds in which it says hello.

    Raises:
        Unreached: It has gone, or says nothing.
    """
    console = Connection(path, place.card(path))
    _exchange([console], b"", lambda one: bool(one.hello), within)
    if console.is_dead or console.fault:
        console.close()
        raise Unreached(GONE if console.is_dead or console.has_gone else console.fault)
    console.wait()
    return console


def stop(
    asked: Mapping[str, Any],
    notice: Callable[[str], None],
    more: Mapping[str, Any] | None = None,
) -> list[Stopped]:
    """Send STOP to every console that could be meant, before any is waited for.

    Args:
        asked: `to`, `engine` and `domain`, as `protocol.is_meant` takes them.
        notice: Is told at once what a person should know while others are waited for.
        more: What else the request says.

    Returns:
        How it ended at each console that is meant; `lost` where none knows.

    Raises Unreached when none could be meant.
    """
    faults: list[str] = []
    meant = _with_variable(asked)
    ended = _stop_each(meant, notice, more or {}, faults)
    if not ended and not asked.get("to") and meant.get("to"):
        ended = _stop_each(asked, notice, more or {}, [])
        if ended:
            notice(f"no console {meant['to']} runs here, which {CHOSEN} names: STOP went to all")
    if not ended:
        raise Nobody(nobody(meant, faults))
    for fault in faults:
        notice(fault)
    return ended


def _stop_each(
    asked: Mapping[str, Any],
    notice: Callable[[str], None],
    more: Mapping[str, Any],
    faults: list[str],
) -> list[Stopped]:
    found = _candidates(asked, faults)
    first = line({"id": 1, "words": ["stop"], **more, **asked})
    began = time.monotonic()

    def is_over(console: Connection) -> bool:
        late = not console.hello and time.monotonic() > began + WAKES
        return console.result is not None or late

    _exchange(found, first, is_over, SOON)
    for console in found:
        if not (console.hello or console.result or console.is_dead or console.has_gone):
            notice(f"{console.called} does not answer yet: STOP waits for it")
    _exchange(found, first, is_over, ANSWERS - SOON)
    ended = [_stopped(console) for console in found if not console.is_dead]
    for console in found:
        console.close()
    return [one for one in ended if one.code != NOT_MEANT]


def _stopped(console: Connection) -> Stopped:
    result = console.result
    if result is not None:
        code, text = result["code"], result.get("text")
        is_text = isinstance(code, str) and isinstance(text, str)
        return Stopped(console.described, *((code, text) if is_text else (LOST, UNCONFIRMED)))
    why = "the console does not answer, and stops it when it does"
    if console.socket is None:
        why = "STOP could not be written to the console"
    elif console.has_gone:
        why = "the console is gone"
    return Stopped(console.described, LOST, f"{UNCONFIRMED}; {why}")


def _with_variable(asked: Mapping[str, Any]) -> dict[str, Any]:
    """What is asked, and of the environment which console is meant where nothing else says so."""
    to = asked.get("to") or os.environ.get(CHOSEN, "")
    return {**asked, "to": to} if to else dict(asked)


def _candidates(asked: Mapping[str, Any], faults: list[str]) -> list[Connection]:
    """All sockets, but for those whose cards say that they are not meant. Raises Unreached."""
    if not hasattr(socket, "AF_UNIX"):
        raise Unreached("this system has no sockets for it: only Linux and macOS do")
    made = [Connection(path, place.card(path)) for path in place.sockets(faults)]
    return [one for one in made if _could(asked, one)]


def _could(asked: Mapping[str, Any], console: Connection) -> bool:
    """False for one that says, or whose card says, that it is another."""
    return not console.who or is_meant(asked, console.who)


def _exchange(
    consoles: Sequence[Connection], first: bytes, is_over: Callable[[Connection], bool], s: float
) -> None:
    """Connect to all, say `first` to each, and read until it `is_over` with each, or `s` passed."""
    end = time.monotonic() + s
    while True:
        for console in consoles:
            if console.socket is None and not (console.is_dead or console.has_gone):
                console.connect(first)
        waiting = [one for one in consoles if not (one.is_dead or one.has_gone or is_over(one))]
        left = end - time.monotonic()
        if not waiting or left <= 0:
            return
        is_refused = any(console.socket is None for console in waiting)
        left = min(left, _AGAIN if is_refused else _LOOK)
        with selectors.DefaultSelector() as selector:  # select.select takes no descriptor over 1023
            for console in waiting:
                if console.socket is not None:
                    selector.register(console.socket, selectors.EVENT_READ, console)
            if not selector.get_map():
                time.sleep(left)
            for key, _ in selector.select(left) if selector.get_map() else ():
                key.data.read()


def _silent(asked: Mapping[str, Any], silent: Sequence[Connection], all_: Sequence[Any]) -> str:
    """That nothing is chosen while one that could be meant does not answer."""
    said = "; ".join(console.fault for console in silent)
    if asked.get("to"):
        return f"no console {asked['to']} answers here; {said}"
    if len(all_) == 1:
        return said
    return f"{said}; nothing is chosen while it could be meant: --to PID or --to NAMESPACE chooses"


def _several(asked: Mapping[str, Any], found: Sequence[Connection]) -> str:
    lines = "".join(f"\n  {console.described}" for console in found)
    if not asked.get("to"):
        return f"several consoles run here, --to PID or --to NAMESPACE chooses:{lines}"
    names = "".join(f"\n  --to {one.who.get('name', '')}  {one.described}" for one in found)
    return f"--to {asked['to']} fits several consoles, the names of their sockets choose:{names}"


def nobody(asked: Mapping[str, Any], faults: Sequence[str]) -> str:
    """Return that no console runs that is meant, and what may be the cause."""
    to, by_name = asked.get("to", ""), os.environ.get(CHOSEN, "")
    said = NOBODY
    if to:
        named = f", which {CHOSEN} names" if to == by_name else ""
        said = f"no console {to} runs here{named} (archo-tui consoles lists them)"
    elif asked.get("engine"):
        domain = asked.get("domain")
        where = asked["engine"] if domain is None else f"{asked['engine']}, domain {domain},"
        said = f"no console of {where} runs here (archo-tui consoles lists them)"
    others = place.other_users()
    hints = [*faults, *(f"a console of {one} runs here: run this as {one}" for one in others)]
    if os.environ.get(place.ONLY):
        hints.append(f"{place.ONLY} is set: only {place.folder()} is looked into")
    return "; ".join((said, *hints))
