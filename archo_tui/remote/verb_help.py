"""`archo-tui VERB --help` and the verbs that exist, also where no console runs."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path

    from archo_tui.verbs.base import Verb

# Verbs whose line of help this program has itself: STOP takes no words, and `wait` is no verb of
# the console's own operator.
_LINES = {
    "stop": "stop: STOP: software stop, holds until released; does not replace the hardware stop",
    "wait": "wait idle|arrived|ready|stopped|battery N: Wait until the robot is in that state",
}
_JSON = "--json", "print one JSON object per line; the last one is the result"
_TO = "--to CONSOLE", "process number or namespace of the console, where several run"
_TIMEOUT = "--timeout S", "give up after S seconds with exit code 4; what was sent is cancelled"
_WAITED = "--timeout S", "give up after S seconds with exit code 4"
_OF_ONE = {
    "status": (("--line", "print one line, for a prompt"),),
    "events": (("--follow", "also print new events as they come"),),
    "echo": (("--once", "print one message; without it each, until ctrl+c"),),
}
_OF_GOALS = (
    ("--wait", "wait until all goals have ended"),
    ("--leave", "with --wait: let goals run on when this is interrupted or times out"),
)
_ASKS = (("--yes", "answer yes to the question"),)


def own(verb: str) -> str:
    """Return the help of a verb that only clients have; an empty string of any other."""
    return with_options(verb, _LINES[verb]) if verb in _LINES else ""


def verbs_of_file(path: Path | None = None) -> dict[str, Verb]:
    """Return the verbs of a console of that robot file by what is typed; None: ARCHO's file."""
    from archo_tui.robot.state import TypedField
    from archo_tui.robot_file.load import default_path, load
    from archo_tui.verbs import verbs

    robot = load(path or default_path())
    return verbs(
        robot,
        {goal.id: [TypedField(path, "int32", 0) for path in goal.form] for goal in robot.goals},
    )


def help_of(verb: str, path: Path | None = None) -> str:
    """Return the help of a verb; an empty string when a robot file (`path`) has none so named."""
    found = verbs_of_file(path).get(verb)
    return "" if found is None else with_options(verb, found.explained, found.options)


def with_options(verb: str, line: str, takes: tuple[str, ...] = ()) -> str:
    """Return a verb's own line, and below it its options; `takes` is as `Verb.options`."""
    options = "\n".join(f"  {name:<14}{what}" for name, what in options_of(verb, takes))
    return f"{line}\n\noptions:\n{options}"


def every_option() -> list[str]:
    """Return the options of all verbs."""
    own = (option for options in _OF_ONE.values() for option in options)
    all_of_them = (_JSON, _TO, _TIMEOUT, *_ASKS, *_OF_GOALS, *own)
    return [name.partition(" ")[0] for name, _ in all_of_them]


def options_of(verb: str, takes: tuple[str, ...] = ()) -> tuple[tuple[str, str], ...]:
    """Return the options of a verb, each with what it does."""
    if verb == "stop":
        return _JSON, _TO
    own = (*_ASKS, *_OF_GOALS, *_OF_ONE.get(verb, ()))
    flags = {*takes, *(name for name, _ in _OF_ONE.get(verb, ()))}
    found = (option for option in own if option[0] in flags)
    return *found, _WAITED if verb == "wait" else _TIMEOUT, _JSON, _TO
