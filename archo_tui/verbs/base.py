"""The base of verbs: one thing that an operator can do, through whichever frontend."""

from __future__ import annotations

from collections.abc import Awaitable, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.robot.outcome import WATCHING, Outcome
from archo_tui.robot_file.model import Limit
from archo_tui.station.station import Station

Values = Mapping[str, Any]  # What was typed, by the names of the arguments.
DISCOVERY_TIME = 2.0  # Seconds after the start by which every server on the graph is found.
ROBOT_TIMEOUT = 5.0  # Seconds after the start (`Station.age`) in which a robot may appear.
ANSWERS = 5.0  # Seconds to wait for answers to earlier requests, which have deadlines.


class Argument(NamedTuple):
    """A value that a verb takes.

    Attributes:
        name: The name; with a leading `--`, as in `--all`, the argument is a flag.
        type: The type as ROS names it: int32, double, string, sequence<int32>.
        many: True if it takes all further words, each as a value.
        rest: True if it takes all further words as one text.
        optional: True if the words may end before it.
        low: The least value, or the parameter that has it; None for no limit. `high` likewise.
        unit: The unit for people, as `m/s`; "" for none.
    """

    name: str
    type: str = "string"
    many: bool = False
    rest: bool = False
    optional: bool = False
    low: Limit = None
    high: Limit = None
    unit: str = ""

    @property
    def is_flag(self) -> bool:
        return self.name.startswith("--")


class Question(NamedTuple):
    """A question that a person answers before something is done.

    Attributes:
        text: The question; the lines after the first one are details.
        safe: The answer that changes nothing, as `Stay stopped`.
        go: The answer that runs the verb, as `Release`; "" if the verb cannot run.
    """

    title: str
    text: str
    safe: str
    go: str


def split_options(words: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
    """Return the words before the first `--` and those behind it, which are no options."""
    if "--" not in words:
        return words, ()
    end = list(words).index("--")
    return words[:end], words[end + 1 :]


class Verb:
    """The base of all verbs; frontends run them, and decide nothing themselves.

    Attributes:
        id: The word that is typed.
        title: The name on the screen.
        help: The description of what it does, in one sentence.
        arguments: The values that it takes, in the order in which they are typed.
        acts: True if it changes something: it does not run while the console only watches.
        moves: True if it may set the robot in motion.
        urgent: True if it runs before verbs that wait.
        survives_stop: True if it runs even if a STOP was read after it.
        tells: True if the text of its outcome is what the person asked for, in lines.
        may_ask: True if `question` may return one.
        started_text: The text that is shown at once if the outcome takes seconds; "" for others.
        has_goals: True if it sends goals, whose ends can be waited for.
        service: The service or action that a node must offer, as the robot file names it; "" for
            none.
    """

    id: str
    title: str
    help: str
    arguments: tuple[Argument, ...] = ()
    acts = False
    moves = False
    urgent = False
    survives_stop = False
    tells = False
    may_ask = False
    started_text = ""
    has_goals = False
    service = ""

    def values(self, words: Sequence[str]) -> Values:
        """Return the values that the words after the verb mean, by the names of the arguments.

        A value is the typed text; for `many` a list of texts; for a flag, which may stand anywhere
        among the words, True. Arguments that were not typed are left out, but `many` is [] then.
        Behind the word `--` nothing is a flag. Verbs for goals return parsed values instead.

        Raises:
            ValueError: The words are too few or too many; the message is one line.
        """
        typed, literal = split_options(words)
        given: dict[str, Any] = {
            a.name: True for a in self.arguments if a.is_flag and a.name in typed
        }
        words = [*(word for word in typed if word not in given), *literal]
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
        """Return `: ` and the line that was probably meant by refused words, or ""."""
        return ""

    @property
    def usage(self) -> str:
        """The arguments as help shows them: `NODE NAME VALUE`, `[--all]`; "" for none."""
        return " ".join(map(_usage, self.arguments))

    @property
    def options(self) -> tuple[str, ...]:
        """The options that a shell may put after the verb: `--wait`, `--leave`, `--yes`."""
        goals = ("--wait", "--leave") if self.has_goals else ()
        return (*goals, "--yes") if self.may_ask else goals

    @property
    def help_line(self) -> str:
        """The line of help: `get NODE NAME: Show a parameter`."""
        return f"{f'{self.id} {self.usage}'.rstrip()}: {self.help}"

    def acts_with(self, values: Values) -> bool:
        """Return True if the verb changes something with these values; by default, `acts`."""
        return self.acts

    def tells_with(self, values: Values) -> bool:
        """Return True if the text of the outcome must be printed, since no event shows it."""
        return self.tells

    def refusal(self, station: Station) -> str:
        """Return the reason why the verb cannot run now, or "".

        A console that only watches refuses every verb that acts; else `disabled_reason` decides.
        """
        if self.acts and station.robot.watching:
            return WATCHING
        return self.disabled_reason(station)

    def disabled_reason(self, station: Station) -> str:
        """Return the reason why the verb cannot run now, or "", for a console that may act.

        By default, a verb with a `service` cannot run while no node offers it as the file says.
        """
        return station.robot.snapshot.unavailable(self.service) if self.service else ""

    def is_ready(self, station: Station, values: Values) -> bool:
        """Return False if the verb cannot run yet, but could once more of the robot is found.

        Frontends wait for True, until ROBOT_TIMEOUT seconds after the start at most. By default, a
        verb with a `service` is ready once a node offers it, and any other at once.
        """
        return not self.service or self.service in station.robot.snapshot.offered

    def is_answered(self, station: Station) -> bool:
        """Return False while the answer to an earlier request may still allow or forbid the verb.

        Frontends wait for True, for ANSWERS seconds at most.
        """
        return True

    async def prepare(self, station: Station, values: Values) -> Values:
        """Complete and check the values, before a question is asked; by default, change nothing.

        Returns:
            The values for `question` and `run`: full names, the text of a file.

        Raises:
            ArchoError: A name means nothing, or a file is not valid.
            ValueError: A value does not fit.
        """
        return values

    def question(self, station: Station, values: Values) -> Question | None:
        """Return the question that must be answered before `run`; None, the default, for none."""
        return None

    def run(self, station: Station, values: Values) -> Awaitable[Outcome]:
        """Run the verb, and return an awaitable of its outcome; nothing is asked any more.

        The outcome of a verb with data for `--json` is a `Report`.

        Raises:
            ArchoError: A name means nothing; nothing has been done then.
        """
        raise NotImplementedError


def _usage(argument: Argument) -> str:
    shown = argument.name if argument.is_flag else argument.name.upper()
    shown += " ..." if argument.many else ""
    return f"[{shown}]" if argument.optional or argument.is_flag else shown
