"""The base of verbs: one thing that an operator can do, through whichever frontend."""

from __future__ import annotations

from collections.abc import Awaitable, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.robot.outcome import WATCHING, Outcome
from archo_tui.robot_file.model import Limit
from archo_tui.station.station import Station

Values = Mapping[str, Any]  # What was typed, by the names of the arguments.
THERE = 2.0  # Seconds after the start in which every server on the graph is found.
PATIENCE = 5.0  # Seconds after the start (`Station.age`) in which a robot may appear.
ANSWERS = 5.0  # Seconds to wait for answers to earlier requests, which have deadlines.


class Argument(NamedTuple):
    """A value that a verb takes."""

    name: str  # As typed; `--all` is a flag.
    type: str = "string"  # As rclpy names it: int32, double, string, sequence<int32>.
    many: bool = False  # Takes all further words, each as a value.
    rest: bool = False  # Takes all further words as one text.
    optional: bool = False
    low: Limit = None
    high: Limit = None
    unit: str = ""

    @property
    def is_flag(self) -> bool:
        """Return True for an option without a value."""
        return self.name.startswith("--")


class Question(NamedTuple):
    """A question that a person answers before something is done."""

    title: str
    text: str
    safe: str  # The answer that changes nothing.
    go: str  # The answer that runs the verb; "" if there is none.


class Verb:
    """The base of all verbs; frontends run them, and decide nothing themselves."""

    id: str  # The word that is typed.
    title: str
    help: str  # One sentence.
    arguments: tuple[Argument, ...] = ()
    acts = False  # Changes something, so does not run while watching.
    moves = False  # May set the robot in motion.
    urgent = False  # Runs before verbs that wait.
    survives_stop = False  # Runs also if a STOP was read after it.
    tells = False  # Its outcome is what was asked for, in lines.
    may_ask = False
    begun = ""  # Said at once by a verb whose outcome takes seconds; "" for others.
    has_goals = False  # Sends goals, whose ends can be waited for.
    service = ""  # The service that a node must offer, as in the robot file.

    def values(self, words: Sequence[str]) -> Values:
        """Return the values that the words after a verb mean.

        Raises:
            ValueError: The words do not fit; the message is one line.
        """
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
        """Return what was meant, perhaps, by words that do not fit, or ""."""
        return ""

    @property
    def usage(self) -> str:
        """Return what is typed after the verb: `NODE NAME VALUE`, `[--all]`."""
        return " ".join(map(_usage, self.arguments))

    @property
    def options(self) -> tuple[str, ...]:
        """Return the options that a shell may put after the verb: `--yes`, `--wait`, `--leave`."""
        goals = ("--wait", "--leave") if self.has_goals else ()
        return (*goals, "--yes") if self.may_ask else goals

    @property
    def explained(self) -> str:
        """Return usage and help: `get NODE NAME: Show a parameter`."""
        return f"{f'{self.id} {self.usage}'.rstrip()}: {self.help}"

    def acts_with(self, values: Values) -> bool:
        """Return True if the verb changes something with these values."""
        return self.acts

    def tells_with(self, values: Values) -> bool:
        """Return True if no event tells the outcome for these values."""
        return self.tells

    def refusal(self, station: Station) -> str:
        """Return why the verb cannot run now, or "".

        A console that only watches refuses every verb that acts; else `disabled_reason` decides.
        """
        if self.acts and station.robot.watching:
            return WATCHING
        return self.disabled_reason(station)

    def disabled_reason(self, station: Station) -> str:
        """Return why the verb cannot run for an operator who may act, or ""."""
        return station.robot.snapshot.unavailable(self.service) if self.service else ""

    def is_ready(self, station: Station, values: Values) -> bool:
        """Return False while the verb may become possible by itself, with a robot just found."""
        return not self.service or self.service in station.robot.snapshot.offered

    def is_answered(self, station: Station) -> bool:
        """Return False while an answer to something sent before decides about this verb."""
        return True

    async def prepare(self, station: Station, values: Values) -> Values:
        """Read what must be read before a question can be asked, and return the values to run with.

        Raises:
            ArchoError: A name means nothing, or a file is not valid.
        """
        return values

    def asks(self, station: Station, values: Values) -> Question | None:
        """Return the question that must be answered first, or None."""
        return None

    def data(self, station: Station, values: Values) -> Any:
        """Return what the verb tells, as JSON has it, or None."""
        return None

    def run(self, station: Station, values: Values) -> Awaitable[Outcome]:
        """Run the verb.

        Raises:
            ArchoError: A name means nothing; nothing has been done then.
        """
        raise NotImplementedError


def _usage(argument: Argument) -> str:
    shown = argument.name if argument.is_flag else argument.name.upper()
    shown += " ..." if argument.many else ""
    return f"[{shown}]" if argument.optional or argument.is_flag else shown
