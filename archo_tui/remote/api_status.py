"""The state of the robot and of its goals, as `archo_tui.connect()` returns it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar

_Kind = TypeVar("_Kind")


@dataclass(frozen=True)
class Battery:
    """The last reading of the battery.

    Attributes:
        percentage: 0 to 100; None: not received.
        voltage: In V; None: not received, or not reported by this robot.
        age: Seconds since the reading; None: never received.
    """

    percentage: float | None
    voltage: float | None
    charging: bool | None
    word: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Motion:
    """The last report of the robot about its motion.

    Attributes:
        stopped: True while a STOP is latched; None: not certain, or not reported.
        speed: In m/s; None: not received.
        age: Seconds since the report; None: never received.
    """

    moving: bool | None
    stopped: bool | None
    speed: float | None
    word: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Goal:
    """The state of a goal at one moment.

    Attributes:
        code: How it ended: `arrived`, `cancelled`, `aborted`; None while it runs.
        mine: True when this console sent it, whoever asked the console to.
        remaining: Metres left, as the robot reports them; None: not reported yet.
        length: Metres of the whole way; None: not known.
        age: Seconds since the robot last reported on it; None: never.
    """

    kind: str
    values: Mapping[str, Any]
    name: str
    phase: str
    code: str | None
    mine: bool
    remaining: float | None
    length: float | None
    message: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Queue:
    """The goals that wait, and why they are held; an empty text: they are not."""

    waiting: list[str]
    held: str


@dataclass(frozen=True)
class Alarm:
    """An alarm; `since` is a Unix time in seconds."""

    name: str
    text: str
    priority: str
    state: str
    since: float


@dataclass(frozen=True)
class Status:
    """The state of the robot, as `archo-tui status --json` prints it.

    Attributes:
        stop: `open`: a STOP is not confirmed; `uncertain`: it may no longer hold; else empty.
        line: All of it in one line of text.
    """

    robot: str
    namespace: str
    watching: bool
    battery: Battery
    motion: Motion
    goal: Goal | None
    queue: Queue
    alarms: list[Alarm]
    stop: str
    line: str


def from_reply(kind: type[_Kind], told: Mapping[str, Any]) -> _Kind:
    """Create an object from a console's reply; fields of a newer console are ignored."""
    return kind(**{field.name: told[field.name] for field in fields(kind)})  # type: ignore[arg-type]
