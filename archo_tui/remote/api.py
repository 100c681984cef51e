"""The console from Python: typed, and nothing but what the socket says. Standard library only."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from types import TracebackType
from typing import Any, TypeVar

from archo_tui.errors import ArchoError
from archo_tui.remote import client, finder


class NotDone(ArchoError):
    """What was asked for was not done; `code` says how it ended, in the protocol's words."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


class Refused(NotDone):
    """By the robot or the console; nothing was done."""


class Misused(NotDone):
    """What was asked for cannot be meant; nothing was sent."""


class Aborted(NotDone):
    """The goal ended, and not where it was to."""


class Cancelled(NotDone):
    """The goal was cancelled, by whomever, or is held in the queue."""


class RanOut(NotDone):
    """The time is over; a goal that was waited for still runs."""


class Unreached(NotDone):
    """No console runs here, several do, or it has gone."""


_KINDS: dict[str, type[NotDone]] = {
    "misuse": Misused,
    "aborted": Aborted,
    "cancelled": Cancelled,
    "held": Cancelled,
    "ran_out": RanOut,
    "lost": Unreached,
}
_Kind = TypeVar("_Kind")
_SOON = 3.0  # s in which what is called off ends
_GOOD = ("done", "accepted", "arrived")


@dataclass(frozen=True)
class Battery:
    """The last reading; `age` is in s, None: never heard."""

    percentage: float | None
    voltage: float | None
    charging: bool | None
    word: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Motion:
    """How the robot last said that it moves."""

    moving: bool | None
    stopped: bool | None
    speed: float | None
    word: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Goal:
    """A goal; `code` is None while it runs."""

    kind: str
    values: Mapping[str, Any]
    name: str
    phase: str
    code: str | None
    mine: bool  # sent by this console, whoever asked it to
    remaining: float | None
    length: float | None
    message: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Queue:
    """What is driven next, and why it is held where it is."""

    waiting: list[str]
    held: str


@dataclass(frozen=True)
class Alarm:
    """One alarm; `since` is a Unix time."""

    name: str
    text: str
    priority: str
    state: str
    since: float


@dataclass(frozen=True)
class Status:
    """All that `archo-tui status --json` tells."""

    robot: str
    namespace: str
    watching: bool
    battery: Battery
    motion: Motion
    goal: Goal | None
    queue: Queue
    alarms: list[Alarm]
    stop: str  # `open`: a STOP is not confirmed; `uncertain`: it is no longer certain
    line: str


class Robot:
    """The robot of one console. Use as a context manager; each call ends as the console says."""

    def __init__(self, to: str) -> None:
        """Raises Unreached."""
        try:
            self._connection = finder.choose({"to": to})
        except client.Unreached as error:
            raise Unreached("unreached", str(error)) from None

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leave; a goal that is being waited for is cancelled."""
        self._connection.close()

    def status(self) -> Status:
        """The state of the robot."""
        told = self.do("status")
        return _made(
            Status,
            {
                **told,
                "battery": _made(Battery, told["battery"]),
                "motion": _made(Motion, told["motion"]),
                "goal": _made(Goal, told["goal"]) if told["goal"] else None,
                "queue": _made(Queue, told["queue"]),
                "alarms": [_made(Alarm, alarm) for alarm in told["alarms"]],
            },
        )

    def go(
        self, *numbers: float, kind: str = "go", wait: bool = True, **values: Any
    ) -> Goal | None:
        """Drive there, or to several one after the other; `pose` and its like take `x=1.5, y=2`.

        Returns the last goal at its end, None without `wait`. Raises Refused, Aborted, Cancelled.
        """
        words = [*map(_text, numbers), *(f"{name}={_text(v)}" for name, v in values.items())]
        told = self.do(kind, *words, wait=wait)
        return None if told is None or not wait else _made(Goal, told)

    def cancel(self) -> None:
        """Cancel the running goal of this console."""
        self.do("cancel")

    def stop(self) -> None:
        """STOP: overtakes whatever waits, is final, and stays until it is released."""
        self.do("stop")

    def set(self, node: str, name: str, value: Any) -> None:
        """Set a parameter to a value of its type."""
        self.do("set", node, name, _text(value))

    def get(self, node: str, name: str) -> Any:
        """The value of a parameter."""
        return self.do("get", node, name)["value"]

    def wait(self, *what: str | float, timeout: float | None = None) -> None:
        """Wait for `idle`, `arrived`, `ready` or `battery`, 50. Raises RanOut after `timeout` s."""
        self.do("wait", *map(_text, what), timeout=timeout)

    def events(self) -> Iterator[dict[str, Any]]:
        """What happens from now on, as `archo-tui events --follow --json` tells it."""
        try:
            for said in self._said(words=["events"], follow=True):
                if "event" in said:
                    yield said["event"]
        finally:  # else what is asked next would wait for its end
            with contextlib.suppress(client.Unreached):
                self._connection.send({"give_up": True})
                next(said for said in self._connection.rest(_SOON) if "code" in said)

    def do(self, *words: str, wait: bool = False, timeout: float | None = None) -> Any:
        """Any verb, by its words; returns what it tells. What asks takes `--yes`."""
        data = None
        for said in self._said(words=list(words), wait=wait, timeout=timeout):
            if said.get("code") in _GOOD:
                data = said.get("data")
            elif "code" in said:
                raise _KINDS.get(said["code"], Refused)(said["code"], said["text"])
        return data

    def _said(self, **asked: Any) -> Iterator[dict[str, Any]]:
        try:
            yield from self._connection.request(**asked)
        except client.Unreached as error:
            raise Unreached("unreached", str(error)) from None


def _made(kind: type[_Kind], told: Mapping[str, Any]) -> _Kind:
    """One of these from what a console says, which may be newer and say more."""
    return kind(**{field.name: told[field.name] for field in fields(kind)})  # type: ignore[arg-type]


def _text(value: Any) -> str:
    """A value as it is typed."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
