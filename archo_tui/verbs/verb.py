"""The base of verbs: one thing that an operator can do, through whichever frontend.

A verb is parsed (`parse`), and run once the robot is found and a person agrees (`run_when_ready`).
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.robot.clients import current_requester
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import WATCHING, Code, Outcome
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.graph import NOT_REPORTED
from archo_tui.robot.state.snapshot import Life
from archo_tui.robot_file.model import RobotFile
from archo_tui.station.station import Station

GOAL_ENDED = "the goal that was asked about has ended"
Values = Mapping[str, Any]  # What was typed, by the names of the arguments.
# The fields of each goal by its id, without goals whose type is not installed.
Forms = Mapping[str, Sequence[TypedField]]
YES = "--yes"  # Answers a verb's question.
TIMEOUT = "--timeout"  # The key of the longest wait in s, for verbs that keep it themselves.
_OPTIONS = (
    ("--json", "print one JSON object per line; the last one is the result"),
    ("--to CONSOLE", "process number or namespace of the console, where several run"),
)
DISCOVERY_TIME = 2.0  # Seconds after the start by which every server on the graph is found.
ROBOT_TIMEOUT = 5.0  # Seconds after the start (`Station.age`) in which a robot may appear.
_ANSWER_TIMEOUT = 5.0  # Seconds to wait for answers to earlier requests, which have deadlines.
_HOSTED_TIMEOUT = 5.0  # Seconds to wait until a node that runs here is found on the graph.
_STARTING_TIMEOUT = 15.0  # Seconds to wait for one whose constructor has not returned.
_RETRY_PERIOD = 0.05  # Seconds between two tries.
_GOAL_POLL_PERIOD = 0.2  # Seconds between two looks whether the goal in question has ended.
# Returns if the answer is yes; raises ArchoError if it is not, or if nobody can be asked.
Ask = Callable[["Question"], Awaitable[None]]
# Gets the words between the verb and the argument that is completed.
Completer = Callable[[Station, Sequence[str]], Iterable[str]]


class Argument(NamedTuple):
    """A value that a verb takes.

    Attributes:
        name: The name; with a leading `--`, as in `--all`, the argument is a flag.
        takes: What stands behind a flag: `HZ`; "" for nothing.
        many: True if it takes all further words, each as a value.
        rest: True if it takes all further words as one text.
        optional: True if the words may end before it.
        completer: Returns the words that a shell offers for it; None for none.
    """

    name: str
    many: bool = False
    rest: bool = False
    optional: bool = False
    completer: Completer | None = None
    takes: str = ""

    @property
    def is_flag(self) -> bool:
        return self.name.startswith("--")


class Question(NamedTuple):
    """A question that a person answers before something is done.

    Attributes:
        text: The question; the lines after the first one are details.
        safe: The answer that changes nothing, as `Stay stopped`.
        go: The answer that runs the verb, as `Release`; "" if the verb cannot run.
        goal: The running goal that it is about; once that has ended nobody is to answer.
    """

    title: str
    text: str
    safe: str
    go: str
    goal: Goal | None = None

    def is_over(self, running: Goal | None) -> bool:
        """Return True once the goal that it is about is not the running one any more."""
        if self.goal is None or running is None:
            return self.goal is not None
        if self.goal.number:
            return running.number != self.goal.number
        # It was on its way to the robot then, and so had no number yet.
        return (running.kind, running.fields) != (self.goal.kind, self.goal.fields)


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
        survives_stop: True if it runs even if a STOP was read after it.
        tells: True if the text of its outcome is what the person asked for, in lines.
        lists: True if it shows all of something, and so waits until that is known.
        may_ask: True if `question` may return one.
        is_slow: True if its outcome takes seconds, and who waits for it can end the waiting.
        started_text: The text that is shown at once; "" for none.
        lasts: True if it goes on while its requester waits, and ends with the waiting.
        own_options: What else a shell may put after it, and what that does.
        timeout_help: What `--timeout S` does for a shell; "" if it is ignored.
        has_goals: True if it sends goals, whose ends can be waited for.
        service: The service or action that a node must offer, as the robot file names it; "" for
            none.
    """

    id: str
    title: str
    help: str
    arguments: tuple[Argument, ...] = ()
    acts = False
    survives_stop = False
    tells = False
    lists = False
    may_ask = False
    is_slow = False
    started_text = ""
    lasts = False
    own_options: tuple[tuple[str, str], ...] = ()
    timeout_help = "give up after S seconds with exit code 4; what was sent is cancelled"
    has_goals = False
    service = ""

    @classmethod
    def of_robot(cls, _robot: RobotFile, _forms: Forms) -> Iterator[Verb]:
        """Yield the verbs of this class for a robot: by default one."""
        yield cls()

    def values(self, words: Sequence[str]) -> Values:
        """Return the values that the words after the verb mean, by the names of the arguments.

        A value is the typed text; for `many` a list of texts; for a flag, which may stand anywhere
        among the words, True, or the text behind it if it takes one. Arguments that were not typed
        are left out, but `many` is [] then. Behind the word `--` nothing is a flag. Verbs for goals
        return parsed values instead.

        Raises:
            ValueError: The words are too few or too many; the message is one line.
        """
        typed, literal = split_options(words)
        flags = {argument.name: argument for argument in self.arguments if argument.is_flag}
        given, kept, remaining = dict[str, Any](), list[str](), iter(typed)
        for word in remaining:
            name, equals, text = word.partition("=")
            if name in flags and flags[name].takes:
                given[name] = text if equals else next(remaining, "")
            elif word in flags:
                given[word] = True
            else:
                kept.append(word)
        words = [*kept, *literal]
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

    @property
    def usage(self) -> str:
        """The arguments as help shows them: `NODE NAME VALUE`, `[--all]`; "" for none."""
        return " ".join(map(_usage, self.arguments))

    @property
    def options(self) -> tuple[tuple[str, str], ...]:
        """The options that a shell may put after the verb, `--timeout S`, and what each does."""
        asks = (("--yes", "answer yes to the question"),) if self.may_ask else ()
        goals = (("--wait", "wait until all goals have ended"),) if self.has_goals else ()
        timeout = (("--timeout S", self.timeout_help),) if self.timeout_help else ()
        return (*asks, *goals, *self.own_options, *timeout, *_OPTIONS)

    @property
    def option_names(self) -> list[str]:
        """The names of all options, flags among the arguments included."""
        flags = [argument.name for argument in self.arguments if argument.is_flag]
        names = (name.partition(" ")[0] for name, _ in self.options)
        return [*dict.fromkeys((*flags, *names))]

    @property
    def help_line(self) -> str:
        """The line of help: `get NODE NAME: Show a parameter`."""
        return f"{f'{self.id} {self.usage}'.rstrip()}: {self.help}"

    @property
    def help_text(self) -> str:
        """The help for a shell: the line, and below it each option with what it does."""
        options = "\n".join(f"  {name:<14}{does}" for name, does in self.options)
        return f"{self.help_line}\n\noptions:\n{options}"

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

    def is_found(self, station: Station, values: Values) -> bool:
        """Return False while the verb needs more of the robot than is known and it may still come.

        By default a verb that `lists` what is known needs all of it, and any other nothing. What
        `refusal` and `prepare` look for needs no further word: `run_when_ready` tries them again.
        """
        return is_settled(station) if self.lists else True

    def is_answered(self, station: Station) -> bool:
        """Return False while the answer to an earlier request may still allow or forbid the verb.

        Frontends wait for True, some seconds at most.
        """
        return True

    async def prepare(self, station: Station, values: Values) -> Values:
        """Complete and check the values, before a question is asked; by default, change nothing.

        Returns:
            The values for `question` and `run`: full names, the text of a file.

        Raises:
            ArchoError: A name means nothing, or a file is not valid.
            ValueError: A value does not fit.
            NotPossible: The robot cannot do it now.
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
    shown = f"{argument.name} {argument.takes}".rstrip()
    shown = shown if argument.is_flag else argument.name.upper()
    shown += " ..." if argument.many else ""
    return f"[{shown}]" if argument.optional or argument.is_flag else shown


class NotPossible(ArchoError):
    """The error for what the robot does not allow now: refused, and no misuse."""


class NotOnGraphError(ArchoError, ValueError):
    """The error for a name that no node on the graph has, or has yet."""


class UnknownVerbError(ValueError):
    """The error for a word that is no verb; its text names the nearest verb, or `help`."""


def named(verbs: Mapping[str, Verb], word: str) -> Verb:
    """Return the verb with a word, which must be spelled exactly; raise UnknownVerbError."""
    if word in verbs:
        return verbs[word]
    hint = nearest_hint(word.lower(), verbs) or " (help lists them)"
    raise UnknownVerbError(f"no command {word!r}{hint}")


def parse(verb: Verb, words: Sequence[str]) -> tuple[Values, bool]:
    """Parse the words after a verb into values, and True for `--yes`; or raise ValueError.

    `--yes` may stand anywhere before `--`, if the verb may ask.
    """
    options, literal = split_options(words)
    yes = verb.may_ask and YES in options
    if yes:
        kept = [word for word in options if word != YES]
        words = [*kept, "--", *literal] if literal else kept
    return verb.values(words), yes


def candidates(verbs: Mapping[str, Verb], station: Station, words: Sequence[str]) -> list[str]:
    """Return the words that may stand at the end of a line, each once; the last one is unfinished.

    Names on the graph have their first `/` only if that has one. Numbers are sorted by value.
    """
    *before, unfinished = words
    if not before:
        return [verb for verb in verbs if verb.startswith(unfinished)]
    verb, number = verbs.get(before[0]), len(before) - 1
    if verb and unfinished.startswith("-"):
        return [name for name in verb.option_names if name.startswith(unfinished)]
    arguments = [a for a in verb.arguments if not a.is_flag] if verb else []
    at = number if number < len(arguments) or not arguments or not arguments[-1].many else -1
    completer = arguments[at].completer if -1 <= at < len(arguments) and arguments else None
    found = completer(station, before[1:]) if completer else ()
    if not unfinished.startswith("/"):
        found = (name.removeprefix("/") for name in found)
    wanted = {name for name in found if name.startswith(unfinished)}
    return sorted(wanted, key=lambda word: (0, int(word), "") if word.isdecimal() else (1, 0, word))


def is_settled(station: Station) -> bool:
    """Return True once all that the robot file names is known, or is not expected any more.

    What no node offers is waited for until DISCOVERY_TIME seconds after the start, and values that
    a node has not sent, its parameters too, until ROBOT_TIMEOUT.
    """
    snapshot, robot = station.robot.snapshot, station.robot.file
    if station.age >= ROBOT_TIMEOUT:
        return True
    readings = (robot.battery, snapshot.battery), (robot.motion, snapshot.motion)
    missing = [named.topic for named, now in readings if named is not None and now.received is None]
    if station.age < DISCOVERY_TIME:
        stop = robot.stop
        wanted = [*(kind.action for kind in robot.goals), *(c.service for c in robot.commands)]
        wanted += [stop.service, stop.release] if stop is not None else []
        missing += [name for name in wanted if name and name not in snapshot.offered]
    else:
        missing = [name for name in missing if name in snapshot.offered]
    are_reported = NOT_REPORTED not in snapshot.unreported.values()
    return bool(snapshot.nodes) and are_reported and not missing


def _awaits_hosted(station: Station, waited: float) -> bool:
    """Return True while a node that runs here may still come to the graph.

    One whose constructor has not returned has 15 s for that, any other 5 s.
    """
    seen = {node.name for node in station.robot.snapshot.nodes}
    lives = [n.life for n in station.host.states() if n.life.is_running and n.name not in seen]
    return bool(lives) and waited < (
        _STARTING_TIMEOUT if Life.STARTING in lives else _HOSTED_TIMEOUT
    )


async def prepare_when_found(station: Station, verb: Verb, values: Values) -> Values | Outcome:
    """Return the values for a verb's `question` and `run`, or why it is refused.

    What is refused is tried again until the robot is settled, for a missing name at least until
    DISCOVERY_TIME, and until ROBOT_TIMEOUT for a missing `service`, or for a name of a robot that
    runs elsewhere; at any time, a missing name or service is waited for while a node that runs here
    may still come to the graph. Raises what `prepare` raises, and Void if a STOP was read
    meanwhile, unless the verb changes nothing or survives a STOP.
    """
    acts, gate, requester = verb.acts_with(values), station.robot.stops.gate(), current_requester()
    if acts and station.robot.watching:
        return Outcome(Code.WATCHING, WATCHING)
    is_void = acts and not verb.survives_stop
    began = station.clock.monotonic()
    while True:
        if is_void:
            gate()
        is_last = station.age >= ROBOT_TIMEOUT or requester.has_left
        waited = station.clock.monotonic() - began
        is_due = verb.is_answered(station) or waited >= _ANSWER_TIMEOUT
        if requester.has_left or (is_due and (is_last or verb.is_found(station, values))):
            try:
                if not (reason := verb.disabled_reason(station)):
                    return await verb.prepare(station, values)
                fault: Exception = NotPossible(reason)
            except (ArchoError, ValueError) as error:
                fault = error
            # A node that the robot file does not name may be found after those that it names.
            is_name = isinstance(fault, NotOnGraphError)
            is_offered = not verb.service or verb.service in station.robot.snapshot.offered
            may_come = is_name and (station.attached or station.age < DISCOVERY_TIME)
            may_come |= not is_offered
            is_hosted = (is_name or not is_offered) and not requester.has_left
            is_hosted = is_hosted and _awaits_hosted(station, waited)
            if not is_hosted and (is_last or (is_settled(station) and not may_come)):
                if isinstance(fault, NotPossible):
                    return Outcome(Code.REFUSED, str(fault))
                raise fault
        await station.clock.sleep(_RETRY_PERIOD)


async def run_when_ready(
    station: Station, verb: Verb, values: Values, ask: Ask | None = None
) -> Outcome:
    """Run a verb once the robot is found, earlier requests are answered, and the person agrees.

    `ask` is None if `--yes` has answered. Raises as `prepare_when_found` does.
    """
    is_void = verb.acts_with(values) and not verb.survives_stop
    gate = station.robot.stops.gate()
    prepared = await prepare_when_found(station, verb, values)
    if isinstance(prepared, Outcome):
        return prepared
    question = verb.question(station, prepared)
    if question is not None and question.go and ask is not None:
        if not await _is_agreed(station, question, ask):
            return Outcome(Code.REFUSED, GOAL_ENDED)
        if is_void:
            gate()
    return await verb.run(station, prepared)


async def _is_agreed(station: Station, question: Question, ask: Ask) -> bool:
    """Ask, and return True for a yes; False once its goal has ended, which waits for no answer."""
    if question.goal is None:
        await ask(question)
        return True
    asking = asyncio.ensure_future(ask(question))
    try:
        while not question.is_over(station.running_goal):
            with suppress(TimeoutError):
                await station.clock.wait_for(asyncio.shield(asking), _GOAL_POLL_PERIOD)
                return not question.is_over(station.running_goal)
        return False
    finally:
        asking.cancel()
