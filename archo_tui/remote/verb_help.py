"""`archo-tui VERB --help`: the options of verbs, which are the client's own, and what it knows."""

from __future__ import annotations

# verbs whose line the client has itself: STOP takes no word behind it, and `wait` is no verb of
# the console's own operator
_LINES = {
    "stop": "stop: STOP: software stop, at once and latched; does not replace the hardware one",
    "wait": "wait idle|arrived|ready|battery N: Wait until it is so",
}
_OF_ALL = (
    ("--json", "one JSON object a line, the last one is the result"),
    ("--to CONSOLE", "where several consoles run: its process number or namespace"),
)
_OF_ONE = {
    "stop": (),
    "wait": (("--timeout S", "end with 4 when it is not so within S seconds"),),
    "status": (("--line", "in one line, for a prompt"),),
    "events": (("--follow", "those that come from now on, too"),),
}
_OF_OTHERS = (
    ("--yes", "where it asks: the answer is yes"),
    ("--wait", "of goals: end when all have ended"),
    ("--timeout S", "with --wait: end with 4 after S seconds; goals run on"),
    ("--leave", "with --wait: goals run on when this is interrupted"),
)


def own(verb: str) -> str:
    """What is said without a console; empty: one is to be asked."""
    return with_options(verb, _LINES[verb]) if verb in _LINES else ""


def with_options(verb: str, line: str) -> str:
    """The verb's own line, and below it the options that it takes."""
    options = (*_OF_ONE.get(verb, _OF_OTHERS), *_OF_ALL)
    return "\n".join((line, "", "options:", *(f"  {name:<14}{what}" for name, what in options)))
