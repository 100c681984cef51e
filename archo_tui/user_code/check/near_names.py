"""The recognition of names that were meant to be the chapter's."""

from __future__ import annotations

import re
from collections.abc import Collection
from difflib import SequenceMatcher

from archo_tui.ros_names import base_name
from archo_tui.user_code.check.check_runner import CheckRunner
from archo_tui.user_code.check.tap import Result

_MIN_SIMILARITY = 0.8  # Ratio of difflib from which a name counts as a misspelling.
# The robot's own names; none of them is a misspelling of another.
_ROBOT_NAMES = {
    *("battery_level", "battery_drain", "motor_status", "set_charging", "reset_encoder"),
    *("emergency_stop", "release_emergency_stop", "move_to_shelf"),
    *("max_speed", "wheel_radius", "low_battery_threshold", "publish_period", "shelf_count"),
}


def missing_result(
    runner: CheckRunner, title: str, wanted: str, verb: str, kind: str, others: Collection[str]
) -> Result:
    """Return the outcome of a check of something that no node offers.

    The check fails if another name was probably meant to be the wanted one, and is skipped
    otherwise; the hint or reason lists such names, else all other names. ARCHO's own names are left
    out.
    """
    others = sorted(name for name in others if name.strip("/") not in _ROBOT_NAMES)
    meant = [name for name in others if _is_meant_as(name, wanted)]
    if meant or others:
        where = runner.find_text((meant or others)[0])
        hint = f"{where}you {verb} {', '.join(meant or others)}; the chapter's {kind} is {wanted}"
        return Result(title, hint=hint) if meant else Result(title, skipped=hint)
    return Result(title, skipped=f"no node {_third_person(verb)} {wanted}")


def _is_meant_as(name: str, wanted: str) -> bool:
    """Return True if a name was probably meant to be the wanted one; any namespace is ignored.

    A name counts if its spelling is similar, or if it has all words of the wanted name, or only
    such words.
    """
    last = base_name(name)
    if SequenceMatcher(None, last.lower(), wanted).ratio() >= _MIN_SIMILARITY:
        return True
    own, words = _words(last), _words(wanted)
    return bool(own) and (own <= words or words <= own)


def _words(name: str) -> set[str]:
    """Return the words of a name in snake_case or camelCase, in lower case; digits are left out."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


def _third_person(verb: str) -> str:
    """Return `publishes` for `publish`, `subscribes to` for `subscribe to`."""
    first, *rest = verb.split(" ")
    return " ".join([first + ("es" if first.endswith("sh") else "s"), *rest])
