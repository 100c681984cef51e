"""The options that a shell user may put behind a verb, and the help of `archo-tui VERB --help`."""

from __future__ import annotations

# Verbs whose line of help this program has itself: STOP takes no words, and `wait` is no verb of
# the console's own operator.
_LINES = {
    "stop": "stop: STOP: software stop, holds until released; does not replace the hardware stop",
    "wait": "wait idle|arrived|ready|stopped|left N|battery N: "
    "Wait until the robot is in that state",
}
_JSON = "--json", "print one JSON object per line; the last one is the result"
_TO = "--to CONSOLE", "process number or namespace of the console, where several run"
_TIMEOUT = "--timeout S", "give up after S seconds with exit code 4; what was sent is cancelled"
_WAIT_TIMEOUT = "--timeout S", "give up after S seconds with exit code 4"
_OPTIONS_OF_VERB = {
    "status": (("--line", "print one line, for a prompt"),),
    "events": (("--follow", "also print new events as they come"),),
    "pub": (
        ("--rate HZ", "publish again and again, so many times a second"),
        ("--times N", "publish N times, once a second without --rate"),
    ),
    "echo": (("--once", "print one message; without it each, until ctrl+c"),),
}
_GOAL_OPTIONS = (
    ("--wait", "wait until all goals have ended"),
    ("--leave", "with --wait: let goals run on when this is interrupted or times out"),
)
_QUESTION_OPTIONS = (("--yes", "answer yes to the question"),)


def client_verb_help(verb: str) -> str:
    """Return the help of `stop` or `wait`, whose text is here; "" for any other verb."""
    return help_with_options(verb, _LINES[verb]) if verb in _LINES else ""


def help_with_options(verb: str, line: str, takes: tuple[str, ...] = ()) -> str:
    """Return the help of a verb: its line, and below it its options with what each does."""
    options = "\n".join(f"  {name:<14}{what}" for name, what in options_of(verb, takes))
    return f"{line}\n\noptions:\n{options}"


def every_option() -> list[str]:
    """Return the names of the options of all verbs, such as `--json`."""
    options = (option for options in _OPTIONS_OF_VERB.values() for option in options)
    all_of_them = (_JSON, _TO, _TIMEOUT, *_QUESTION_OPTIONS, *_GOAL_OPTIONS, *options)
    return [name.partition(" ")[0] for name, _ in all_of_them]


def options_of(verb: str, takes: tuple[str, ...] = ()) -> tuple[tuple[str, str], ...]:
    """Return what is typed, `--timeout S`, and what it does, of each option of a verb."""
    if verb == "stop":
        return _JSON, _TO
    possible = (*_QUESTION_OPTIONS, *_GOAL_OPTIONS, *_OPTIONS_OF_VERB.get(verb, ()))
    flags = {*takes, *(name for name, _ in _OPTIONS_OF_VERB.get(verb, ()))}
    found = (option for option in possible if option[0] in flags)
    return *found, _WAIT_TIMEOUT if verb == "wait" else _TIMEOUT, _JSON, _TO
