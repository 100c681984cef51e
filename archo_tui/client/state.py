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
        charging: None: not received, or not reported by this robot.
        word: The state in a word, as on the screen.
        age: Seconds since the reading; None: never received.
        source: Always `measured`.
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
        moving: None: not received, or not certain.
        stopped: True while a confirmed STOP holds or the robot reports a stop; None: not
            certain, or not reported.
        speed: In m/s; None: not received.
        word: The state in a word, as on the screen.
        age: Seconds since the report; None: never received.
        source: Always `measured`.
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
        kind: The goal of the robot file, such as `shelf`.
        values: The values of its fields, by name; empty for another client's goal.
        name: The goal in words: `shelf 12`.
        phase: The phase as on the screen: `MOVING`, `ARRIVED`.
        code: The outcome: `arrived`, `cancelled`, `aborted`; None while the goal runs.
        mine: True if this console sent the goal, for a person or a program.
        remaining: Metres left, as the robot reports them; None: not reported yet.
        length: Metres of the whole way; None: not known.
        message: The robot's own text about the end; "" without one.
        age: Seconds since the robot last reported on the goal; None: never.
        source: `commanded` if this console sent the goal, else `measured`.
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
    """The console's queue of goals that are not sent yet.

    Attributes:
        waiting: The goals in words, the next one first.
        held: The reason why no goal is sent until a person continues; "" if the queue is not held.
    """

    waiting: list[str]
    held: str


@dataclass(frozen=True)
class Alarm:
    """An alarm of the console; `since` is a Unix time in seconds."""

    name: str
    text: str
    priority: str
    state: str
    since: float


@dataclass(frozen=True)
class Status:
    """The state of the robot, as `archo-tui status --json` prints it.

    Attributes:
        robot: The name of the robot.
        namespace: The namespace of the robot on the ROS graph.
        watching: True if the console only watches, and sends no command.
        goal: The running goal or, if none runs, the last one; None: no goal is known.
        stop: `open`: the robot has not confirmed a STOP; `uncertain`: the last confirmed STOP may
            no longer hold; "" otherwise, also while one holds: see `motion.stopped`.
        line: The whole state in one line of text.
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


def from_reply(kind: type[_Kind], reply: Mapping[str, Any]) -> _Kind:
    """Create an object of `kind` from a console's reply; entries of a newer console are ignored."""
    return kind(**{field.name: reply[field.name] for field in fields(kind)})  # type: ignore[arg-type]
