"""The verb `pub`, which publishes a message to any topic, as `ros2 topic pub` does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from archo_tui.robot.outcome import Outcome
from archo_tui.ros_names import is_name, parse_type
from archo_tui.station.station import Station
from archo_tui.text.goal import activity
from archo_tui.verbs.names import fields_of, full_name, topic_names, topics_of, type_of
from archo_tui.verbs.verb import ROBOT_TIMEOUT, Argument, NotPossible, Question, Values, Verb

RATE, TIMES = "--rate", "--times"
MAX_RATE = 100.0  # Hz
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
        Argument(RATE, takes="HZ"),
        Argument(TIMES, takes="N"),
    )
    acts = may_ask = lasts = is_slow = True
    own_options = (
        ("--rate HZ", "publish again and again, so many times a second"),
        ("--times N", "publish N times, once a second without --rate"),
    )

    def values(self, words: Sequence[str]) -> Values:
        """Return `topic`, `field=value`, and `rate` and `times` as `frequency` does."""
        given = dict(super().values(words))
        if not is_name(given["topic"]):
            raise ValueError(f"{given['topic']!r} is not a name of a topic, such as /cmd_vel")
        rate, times = frequency(given.pop(RATE, None), given.pop(TIMES, None))
        return {**given, "rate": rate, "times": times}

    def is_found(self, station: Station, values: Values) -> bool:
        """Return False while subscribers of a topic whose type was typed may still come."""
        if not station.attached or station.age >= ROBOT_TIMEOUT:
            return True
        found = [*topic_names(station, ())]
        return full_name(station.robot.snapshot, values["topic"], found) in found

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot = station.robot.snapshot
        found = {topic.name: topic for topic in topics_of(snapshot)}
        name = full_name(snapshot, values["topic"], found)
        words = list(values["field=value"])
        if words and "=" not in words[0] and parse_type(words[0]) is not None:
            kind = words.pop(0)
            if name in found and kind not in found[name].types:
                raise ValueError(f"{name} is {', '.join(found[name].types)}, not {kind}")
        else:
            kind = type_of("topic", name, {each.name: each.types for each in found.values()})
        if any(part.startswith("_") for part in name.split("/")) or name in _OWN:
            raise ValueError(f"{name} is of ROS or the console itself: nothing is published there")
        fields = values.get("fields")  # Of a form.
        if fields is None:
            fields = await fields_of(station, name, kind, words)
        read = {snapshot.full(topic) for topic in snapshot.file.shown_topics}
        nodes = found[name].nodes if name in found else ()
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
        return Question("Publish", text, "No", "Publish", goal)

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.publish(
            *(values["topic"], values["type"], values["fields"]),
            *(values["rate"], values["times"]),
            moves=values["moves"],
        )


def frequency(rate: Any, times: Any) -> tuple[float, int | None]:
    """Return the rate in Hz and how often, None for without end; a given None was left out.

    Without both it is once, with `times` alone once a second; with a rate alone it has no end.

    Raises:
        ValueError: One of both is no such number.
    """
    hertz = None if rate is None else _number(RATE, rate, "a number of Hz")
    count = None if times is None else _number(TIMES, times, "a whole number")
    if hertz is not None and not 0 < hertz <= MAX_RATE:
        raise ValueError(f"{RATE}: more than 0, at most {MAX_RATE:g} Hz, not {hertz:g}")
    if count is not None and (count < 1 or not count.is_integer()):
        raise ValueError(f"{TIMES}: a whole number from 1 on, not {count:g}")
    often = int(count) if count is not None else None if hertz is not None else 1
    return hertz or 1.0, often


def _number(option: str, value: Any, what: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{option} needs {what}, not {value!r}") from None
