"""What a verb is: one thing that an operator can do, however it is said."""

from __future__ import annotations

from collections.abc import Awaitable, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import WATCHING
from archo_tui.robot_file.model import Limit
from archo_tui.station.station import Station

Values = Mapping[str, Any]  # what was typed, by the names of the arguments
THERE = 2.0  # s from the start in which all that serves something is found on the graph
PATIENCE = 5.0  # s from the start (`Station.age`) in which a robot may not be there yet
ANSWERS = 5.0  # s that answers to what was asked before are waited for; each has a deadline itself


class Argument(NamedTuple):
    """One value that a verb takes."""

    name: str  # as it is typed; `--all` is a flag
    type: str = "string"  # as rclpy names it: int32, double, string, sequence<int32>
    many: bool = False  # all the words that are left, each a value
    rest: bool = False  # all the words that are left, as one text
    optional: bool = False
    low: Limit = None
    high: Limit = None
    unit: str = ""

    @property
    def is_flag(self) -> bool:
        """True for one that is there or not."""
        return self.name.startswith("--")


class Question(NamedTuple):
    """What a person is asked before something is done."""

    title: str
    text: str
    safe: str  # the answer that changes nothing
    go: str  # the one that does it


class Verb:
    """Base of all. Keys and `--plain` speak these, and decide nothing themselves."""

    id: str  # what is typed
    title: str
    help: str  # one sentence
    arguments: tuple[Argument, ...] = ()
    acts = False  # changes something: not while watching
    moves = False  # may set the robot in motion
    urgent = False  # overtakes what waits
    survives_stop = False  # done also when a STOP was read after it
    tells = False  # its outcome is what was asked for, in lines
    may_ask = False
    begun = ""  # what is said at once, of a verb whose outcome takes seconds; empty: of all others
    has_goals = False  # sends goals, whose ends can be waited for
    service = ""  # what somebody must offer, as in the robot file

    def values(self, words: Sequence[str]) -> Values:
        """What the words behind the verb mean. Raises ValueError with one line."""
        given: dict[str, Any] = {
            a.name: True for a in self.arguments if a.is_flag and a.name in words
        }
        words = [word for word in words if word not in given]
        wanted = [argument for argument in self.arguments if not argument.is_flag]
        for number, argument in enumerate(wanted):
            if argument.many:
                given[argument.name] = list(words[number:])
            elif argument.rest and number < len(words):
                given[argument.name] = " ".join(words[number:])
            elif number < len(words):
                given[argument.name] = words[number]
        needed = sum(not argument.optional for argument in wanted)
        if len(words) < needed:
            raise ValueError(f"needs {self.usage}")
        if len(words) > len(wanted) and not (wanted and (wanted[-1].many or wanted[-1].rest)):
            raise ValueError(f"takes only {self.usage}" if self.usage else "takes no values")
        return given

    def hint(self, station: Station, words: Sequence[str]) -> str:
        """What was meant, perhaps, by words that it does not take."""
        return ""

    @property
    def usage(self) -> str:
        """What is typed behind the verb: `NODE NAME VALUE`, `[--all]`."""
        return " ".join(map(_usage, self.arguments))

    @property
    def options(self) -> tuple[str, ...]:
        """The options that a shell may put behind it: `--yes`, `--wait`, `--leave`."""
        goals = ("--wait", "--leave") if self.has_goals else ()
        return (*goals, "--yes") if self.may_ask else goals

    @property
    def explained(self) -> str:
        """`get NODE NAME: Show a parameter`."""
        return f"{f'{self.id} {self.usage}'.rstrip()}: {self.help}"

    def acts_with(self, values: Values) -> bool:
        """True when it changes something, given these."""
        return self.acts

    def tells_with(self, values: Values) -> bool:
        """True when its outcome, given these, is in no event."""
        return self.tells

    def refusal(self, station: Station) -> str:
        """Why it cannot be done now, or an empty string: nothing else decides that."""
        if self.acts and station.robot.watching:
            return WATCHING
        return self.blocked(station)

    def blocked(self, station: Station) -> str:
        """As `refusal`, of an operator who may act."""
        return station.robot.snapshot.unavailable(self.service) if self.service else ""

    def is_ready(self, station: Station, values: Values) -> bool:
        """False while it may become possible by itself: the robot was only just found."""
        return not self.service or self.service in station.robot.snapshot.offered

    def is_answered(self, station: Station) -> bool:
        """Return False while an answer to something asked before decides about this verb."""
        return True

    async def prepare(self, station: Station, values: Values) -> Values:
        """Read what has to be read before a question can be put. Raises ArchoError."""
        return values

    def asks(self, station: Station, values: Values) -> Question | None:
        """What is to be answered first; None: nothing."""
        return None

    def data(self, station: Station, values: Values) -> Any:
        """What it tells, as JSON has it; None: it tells nothing."""
        return None

    def run(self, station: Station, values: Values) -> Awaitable[Outcome]:
        """Do it. Raises ArchoError for a name that means nothing, before anything is done."""
        raise NotImplementedError


def _usage(argument: Argument) -> str:
    shown = argument.name if argument.is_flag else argument.name.upper()
    shown += " ..." if argument.many else ""
    return f"[{shown}]" if argument.optional or argument.is_flag else shown
