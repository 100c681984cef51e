"""What a robot file says: what a robot offers, under which names, and what it means.

Everything is optional: what a robot lacks is left out of its file, and greyed on the screen.
`where` is the file and line that a message about it names.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

NO_STOP = "has no STOP: use the hardware stop"  # of a robot whose file names none

Scalar = bool | int | float | str


def _where() -> Any:
    return field(default="", compare=False, repr=False)


@dataclass(frozen=True)
class Field:
    """Where a reading stands in a message: a dotted path, and what to make of the value there."""

    field: str
    scale: float = 1.0
    offset: float = 0.0  # added after scaling
    equals: Scalar | None = None  # true when the value is this
    beyond: float | None = None  # true when the value's size is larger
    unit: str = ""
    where: str = _where()


@dataclass(frozen=True)
class Link:
    """A number that a node of the robot holds as a parameter."""

    node: str
    parameter: str
    otherwise: float | None = None  # while the node does not report it
    where: str = _where()


@dataclass(frozen=True)
class BatteryFields:
    """Of one message type."""

    percentage: Field  # 0 .. 100
    voltage: Field | None = None  # V
    charging: Field | None = None
    health: Field | None = None


@dataclass(frozen=True)
class MotionFields:
    """Of one message type."""

    count: Field | None = None
    speed: Field | None = None
    moving: Field | None = None
    stopped: Field | None = None  # latched by the software stop


@dataclass(frozen=True)
class Battery:
    """The topic that tells the charge."""

    topic: str
    types: Mapping[str, BatteryFields]
    low: Link | None = None  # %; a charge below it is low
    health: Mapping[str, Literal["good", "low", "replace"]] = field(default_factory=dict)
    period: float | None = None  # s between two messages; None: it is measured
    where: str = _where()


@dataclass(frozen=True)
class Motion:
    """The topic that tells how the robot moves."""

    topic: str
    types: Mapping[str, MotionFields]
    title: str = "Motion"
    period: float | None = None  # s between two messages; None: it is measured
    where: str = _where()


@dataclass(frozen=True)
class Input:
    """One field of a goal's form."""

    label: str = ""
    low: float | None = None
    high: float | None = None
    unit: str = ""
    convert: Literal["yaw"] | None = None  # degrees, made a quaternion at this path
    where: str = _where()


@dataclass(frozen=True)
class Remaining:
    """The field of the feedback that says how much is left."""

    field: str
    unit: str = ""
    length: Link | None = None  # of the whole way; without it the first remainder
    where: str = _where()


@dataclass(frozen=True)
class GoalKind:
    """One action of the robot, with the form to fill in."""

    id: str
    title: str
    action: str
    type: str
    noun: str = ""  # of what a goal leads to: "12 m before shelf 12"; empty: it leads nowhere
    key: str = ""
    form: Mapping[str, Input] = field(default_factory=dict)  # by dotted path
    fixed: Mapping[str, Any] = field(default_factory=dict)  # values by dotted path
    remaining: Remaining | None = None
    message: str = ""  # the result's field with the robot's own words for the end
    refusals: str = ""  # log lines of the action's node that begin so hold the reason
    where: str = _where()


@dataclass(frozen=True)
class Stop:
    """The services of the software stop."""

    service: str
    release: str = ""
    where: str = _where()


@dataclass(frozen=True)
class Service:
    """A command: a service whose request has no field, or one bool that is toggled."""

    id: str
    title: str
    service: str
    key: str = ""
    help: str = ""
    ask: Literal["moving", "always", "never"] = "never"
    # request field: reading it inverts; where it is given it is not empty
    toggle: Mapping[str, str] = field(default_factory=dict, metadata={"filled": True})
    off: str = ""  # what a toggle is called, and typed, when it sends false
    where: str = _where()

    @property
    def off_word(self) -> str:
        """What is typed for a toggle to send false; empty when it is not a toggle."""
        return (self.off or f"{self.id}_off") if self.toggle else ""

    def is_about(self, topic: Literal["battery", "motion"]) -> bool:
        """True when it toggles a reading of that topic."""
        return any(reading.startswith(f"{topic}.") for reading in self.toggle.values())


@dataclass(frozen=True)
class Gauge:
    """A further number of the robot's."""

    title: str
    topic: str
    type: str
    field: Field
    unit: str = ""
    low: float | None = None  # beyond low .. high it is not a reading
    high: float | None = None
    warn_below: float | None = None
    warn_above: float | None = None
    where: str = _where()


@dataclass(frozen=True)
class Robot:
    """One robot file."""

    version: Literal[1] = 1
    name: str = "robot"
    battery: Battery | None = None
    motion: Motion | None = None
    goals: tuple[GoalKind, ...] = ()  # the first one has its form on the screen
    stop: Stop | None = None
    commands: tuple[Service, ...] = ()
    gauges: tuple[Gauge, ...] = ()

    @property
    def topics(self) -> tuple[str, ...]:
        """Every topic that is listened to."""
        heard = (self.battery, self.motion)
        named = [topic.topic for topic in heard if topic] + [gauge.topic for gauge in self.gauges]
        return tuple(dict.fromkeys(named))

    @property
    def services(self) -> tuple[str, ...]:
        """Every service that is called."""
        stop = () if self.stop is None else (self.stop.service, self.stop.release)
        named = [*stop, *(command.service for command in self.commands)]
        return tuple(name for name in dict.fromkeys(named) if name)
