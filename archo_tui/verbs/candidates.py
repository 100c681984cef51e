"""The words that may follow a verb, for the completion of a shell."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

from archo_tui.robot.state.graph import LEVELS, TOPIC, Parameter
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.station import Station
from archo_tui.verbs.base import Verb
from archo_tui.verbs.goals import Go
from archo_tui.verbs.graph_names import full_name

TRANSITIONS = "configure", "activate", "deactivate", "cleanup", "shutdown"
_MOST_NUMBERS = 1000  # Numbers of a range, such as shelves, that are listed.


def candidates(verbs: Mapping[str, Verb], station: Station, words: Sequence[str]) -> list[str]:
    """Return the words that may stand at the end of a line, each once.

    The last word is its beginning, which may be ""; names on the graph have their first `/` only if
    that has one. Numbers are sorted by value.
    """
    *before, unfinished = words
    if not before:
        return [verb for verb in verbs if verb.startswith(unfinished)]
    verb, number = verbs.get(before[0]), len(before) - 1
    if isinstance(verb, Go):
        found = _goal_words(verb, station.robot.snapshot)
    else:
        sources = _SOURCES.get(before[0], ())
        found = sources[number](station, before[1:]) if number < len(sources) else ()
    if not unfinished.startswith("/"):
        found = (name.removeprefix("/") for name in found)
    return sorted({name for name in found if name.startswith(unfinished)}, key=_sort_key)


def _sort_key(word: str) -> tuple[int, str]:
    return (int(word), "") if word.isdecimal() else (_MOST_NUMBERS, word)


def _goal_words(verb: Go, snapshot: Snapshot) -> Iterable[str]:
    """Return the numbers that a goal of one number allows; for other goals `FIELD=` per field."""
    if len(verb.arguments) != 1 or not verb.arguments[0].many:
        return [f"{argument.name.lower()}=" for argument in verb.arguments]
    low, high = snapshot.limit(verb.arguments[0].low), snapshot.limit(verb.arguments[0].high)
    if low is None or high is None or not 0 <= low <= high < math.inf:
        return ()
    numbers = range(math.ceil(low), math.floor(high) + 1)
    return map(str, numbers[:_MOST_NUMBERS])


def _hosted(station: Station, _: Sequence[str]) -> Iterable[str]:
    return [hosted.name for hosted in station.host.states()]


def _nodes(station: Station, _: Sequence[str]) -> Iterable[str]:
    return [node.name for node in station.robot.snapshot.nodes]


def _managed_nodes(station: Station, _: Sequence[str]) -> Iterable[str]:
    return [node.name for node in station.robot.snapshot.nodes if node.lifecycle]


def _levels(_: Station, __: Sequence[str]) -> Iterable[str]:
    return [level.lower() for level in LEVELS]


def _transitions(_: Station, __: Sequence[str]) -> Iterable[str]:
    return TRANSITIONS


def _owners(station: Station, _: Sequence[str]) -> Iterable[str]:
    return [parameter.node for parameter in station.robot.snapshot.parameters]


def _parameters_of(station: Station, word: str) -> list[Parameter]:
    snapshot = station.robot.snapshot
    node = full_name(snapshot, word, {parameter.node for parameter in snapshot.parameters})
    return [parameter for parameter in snapshot.parameters if parameter.node == node]


def _parameters(station: Station, words: Sequence[str]) -> Iterable[str]:
    return [parameter.name for parameter in _parameters_of(station, words[0])]


def _values(station: Station, words: Sequence[str]) -> Iterable[str]:
    """Return `true` and `false` for a boolean parameter, nothing for others."""
    kinds = [p.type for p in _parameters_of(station, words[0]) if p.name == words[1]]
    return ("true", "false") if kinds == ["bool"] else ()


def _topics(station: Station, _: Sequence[str]) -> Iterable[str]:
    return [found.name for found in station.robot.snapshot.resources if found.kind == TOPIC]


def _services(station: Station, _: Sequence[str]) -> Iterable[str]:
    return station.robot.snapshot.services


def _actions(station: Station, _: Sequence[str]) -> Iterable[str]:
    return station.robot.snapshot.actions


def _types(station: Station, _: Sequence[str]) -> Iterable[str]:
    return [kind for found in station.robot.snapshot.resources for kind in found.types]


# By verb, a function for each word behind it; it gets the words between the verb and that word.
_SOURCES: Mapping[str, tuple[Callable[[Station, Sequence[str]], Iterable[str]], ...]] = {
    "start": (_hosted,),
    "halt": (_hosted,),
    "copy": (_hosted,),
    "log_level": (_nodes, _levels),
    "lifecycle": (_managed_nodes, _transitions),
    "get": (_owners, _parameters),
    "set": (_owners, _parameters, _values),
    "echo": (_topics,),
    "hz": (_topics,),
    "call": (_services,),
    "send_goal": (_actions,),
    "interface": (_types,),
}
