"""Names that were meant to be the chapter's."""

from __future__ import annotations

import re
from collections.abc import Collection
from difflib import SequenceMatcher

from archo_tui.chapter.asker import Asker
from archo_tui.chapter.tap import Result

_ALIKE = 0.8  # of two names, as difflib has it: from here on one was meant to be the other
# of the robot: none of them is another one's misspelling
_KNOWN = {
    *("battery_level", "battery_drain", "motor_status", "set_charging", "reset_encoder"),
    *("emergency_stop", "release_emergency_stop", "move_to_shelf"),
    *("max_speed", "wheel_radius", "low_battery_threshold", "publish_period", "shelf_count"),
}


def missing(
    asker: Asker, title: str, wanted: str, verb: str, kind: str, others: Collection[str]
) -> Result:
    """Nobody offers what is wanted: a failure where another name was meant to be this one.

    `verb` and `kind` are of what is offered: publish, topic.
    """
    others = sorted(name for name in others if name.strip("/") not in _KNOWN)
    meant = [name for name in others if _is_meant(name, wanted)]
    if meant or others:
        where = asker.place_of_text((meant or others)[0])
        said = f"{where}you {verb} {', '.join(meant or others)}; the chapter's {kind} is {wanted}"
        return Result(title, hint=said) if meant else Result(title, skipped=said)
    return Result(title, skipped=f"no node {_third(verb)} {wanted}")


def _is_meant(name: str, wanted: str) -> bool:
    """A misspelling, the name in a namespace, or some of its words."""
    last = name.rpartition("/")[2]
    if SequenceMatcher(None, last.lower(), wanted).ratio() >= _ALIKE:
        return True
    own, words = _words(last), _words(wanted)
    return bool(own) and (own <= words or words <= own)


def _words(name: str) -> set[str]:
    """Of snake_case and camelCase."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


def _third(verb: str) -> str:
    """`publishes` of publish, `subscribes to` of subscribe to."""
    first, *rest = verb.split(" ")
    return " ".join([first + ("es" if first.endswith("sh") else "s"), *rest])
