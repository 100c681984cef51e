"""The verb `pub`, which publishes a message to any topic, as `ros2 topic pub` does."""

from __future__ import annotations

from collections.abc import Sequence

from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.graph import TOPIC
from archo_tui.ros_names import parse_type
from archo_tui.station.station import Station
from archo_tui.text.goal import activity
from archo_tui.verbs.names import fields_of, full_name, topic_names, type_of
from archo_tui.verbs.verb import Argument, NotPossible, Question, Values, Verb, split_options

RATE, TIMES = "--rate", "--times"
MAX_RATE = 100.0  # Hz
_KINDS = {"--rate": "a number of Hz", "--times": "a whole number"}
_OWN = ("/rosout", "/parameter_events")  # Of ROS itself.


class Publish(Verb):
    """The verb `pub`: publish one message, or many at a rate, to a topic.

    What may move the robot asks first, is refused behind a STOP, and ends at one.
    """

    id, title = "pub", "Publish"
    help = "Publish a message to a topic, once or at a rate; without --times until it is ended"
    arguments = (
        Argument("topic", completer=topic_names),
        Argument("field=value", many=True, optional=True),
        Argument(f"{RATE} HZ", optional=True),
        Argument(f"{TIMES} N", optional=True),
    )
    acts = moves = may_ask = lasts = True

    def values(self, words: Sequence[str]) -> Values:
        """Return `topic`, `field=value`, `rate` in Hz and `times`, None for without end.

        Without both, one message is published; with `--times` alone one a second.
        """
        rest, numbers = _split_numbers(words)
        given = super().values(rest)
        rate, times = numbers.get(RATE), numbers.get(TIMES)
        if rate is not None and not 0 < rate <= MAX_RATE:
            raise ValueError(f"{RATE}: more than 0, at most {MAX_RATE:g} Hz, not {rate:g}")
        if times is not None and (times < 1 or not times.is_integer()):
            raise ValueError(f"{TIMES}: a whole number from 1 on, not {times:g}")
        often = int(times) if times is not None else None if rate is not None else 1
        return {**given, "rate": rate or 1.0, "times": often}

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot = station.robot.snapshot
        found = {r.name: r.types for r in snapshot.resources if r.kind == TOPIC}
        name = full_name(snapshot, values["topic"], found)
        words = list(values["field=value"])
        if words and "=" not in words[0] and parse_type(words[0]) is not None:
            kind = words.pop(0)
            if kind not in found.get(name, (kind,)):
                raise ValueError(f"{name} is {', '.join(found[name])}, not {kind}")
        else:
            kind = type_of("topic", name, found)
        if any(part.startswith("_") for part in name.split("/")) or name in _OWN:
            raise ValueError(f"{name} is of ROS or the console itself: nothing is published there")
        fields = values.get("fields")  # Of a form.
        if fields is None:
            fields = await fields_of(station, name, kind, words)
        read = {snapshot.full(topic) for topic in snapshot.file.shown_topics}
        nodes = next((r.nodes for r in snapshot.resources if r.name == name), ())
        if name in read and nodes:
            raise NotPossible(
                f"the console reads {name}, and {', '.join(nodes)} publishes it: "
                "nothing else is to be shown as the robot's words; stop that node first"
            )
        moves = snapshot.moves_by(name)
        if moves and (reason := station.restart_blocker):
            raise NotPossible(reason)
        return {**values, "topic": name, "type": kind, "fields": fields, "moves": moves}

    def question(self, station: Station, values: Values) -> Question | None:
        if not values.get("moves"):
            return None
        often = "once" if values["times"] == 1 else f"at {values['rate']:g} Hz"
        goal = station.running_goal
        now = f"The robot is {activity(goal)}. " if goal is not None else ""
        what = f"{values['topic']} ({values['type']}) {often}"
        text = f"{now}This may move the robot. Publish to {what}?"
        return Question("Publish", text, "No", "Publish")

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.publish(
            *(values["topic"], values["type"], values["fields"]),
            *(values["rate"], values["times"]),
            moves=values["moves"],
        )


def _split_numbers(words: Sequence[str]) -> tuple[list[str], dict[str, float]]:
    """Return the words without `--rate` and `--times`, and their numbers; raise ValueError."""
    options, literal = split_options(words)
    rest: list[str] = []
    numbers: dict[str, float] = {}
    remaining = iter(options)
    for word in remaining:
        name, equals, text = word.partition("=")
        if name not in _KINDS:
            rest.append(word)
            continue
        text = text if equals else next(remaining, "")
        try:
            numbers[name] = float(text)
        except ValueError:
            raise ValueError(f"{name} needs {_KINDS[name]}, not {text!r}") from None
    return [*rest, *(["--", *literal] if literal else [])], numbers
