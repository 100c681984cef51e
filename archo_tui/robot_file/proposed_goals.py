"""The proposal of a goal's entry in a robot file from the fields of its action's type."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from archo_tui.robot_file import known_types
from archo_tui.robot_file.model import FormField, GoalKind, RemainingField

_FRAME = "map"  # REP 105's fixed frame, in which goals of navigation are given.
# In the name of a feedback field: not in that of `left_wheel_speed`.
_REMAINING = re.compile(r"remaining|to_go|(^|_)left$")
_MESSAGES = ("message", "final_message", "error_msg")  # Names of a result field with words.
_NUMBERS = re.compile(r"u?int(8|16|32|64)|octet|float|double")
_SIMPLE = re.compile(rf"{_NUMBERS.pattern}|boolean|w?string(<\d+>)?")
_STAMP = ("builtin_interfaces/Time", "builtin_interfaces/Duration")  # Their zero is a default.


def propose_goal(
    action: str,
    types: Sequence[str],
    goal: Mapping[str, str] | None,
    feedback: Mapping[str, str],
    result: Mapping[str, str],
) -> GoalKind | None:
    """Propose the entry of a robot file for an action; None if its goal is unknown or fits no form.

    Goal (None if its type is not installed), feedback and result are types by dotted path.
    """
    known = next((known_types.GOALS[kind] for kind in types if kind in known_types.GOALS), None)
    if known is not None:
        return replace(known, action=action)
    form = None if goal is None else _form(goal)
    if form is None:
        return None
    fields, fixed = form
    return GoalKind(
        word_of(action),
        title_of(action),
        action,
        types[0],
        form=fields,
        fixed=fixed,
        remaining=_remaining(feedback),
        message=next((name for name in _MESSAGES if result.get(name) == "string"), ""),
    )


def _form(goal: Mapping[str, str]) -> tuple[dict[str, FormField], dict[str, str]] | None:
    """Return the fields to type and the fixed values of a goal; None if it has a list to fill.

    A pose is typed as x, y and yaw, in the frame that navigation uses. Stamps keep their zero.
    """
    fields: dict[str, FormField] = {}
    fixed: dict[str, str] = {}
    done: list[str] = []  # The paths of messages whose fields are dealt with.
    for path, kind in goal.items():
        if any(path.startswith(f"{message}.") for message in done):
            continue
        if kind in known_types.GOAL_POSES:
            pose, frame = known_types.GOAL_POSES[kind]
            before = f"{path}.{pose}"
            fields[f"{before}position.x"] = FormField(_label("x", path, goal), unit="m")
            fields[f"{before}position.y"] = FormField(_label("y", path, goal), unit="m")
            yaw = FormField(_label("yaw", path, goal), -360, 360, "deg", "yaw")
            fields[f"{before}orientation"] = yaw
            if frame:
                fixed[f"{path}.{frame}"] = _FRAME
            done.append(path)
        elif kind in _STAMP:
            done.append(path)
        elif _SIMPLE.fullmatch(kind):
            fields[path] = FormField()
        elif "/" not in kind or kind.endswith("]") or kind.startswith("sequence"):
            return None
    return fields, fixed


def _label(word: str, path: str, goal: Mapping[str, str]) -> str:
    """Return the label of a pose's field: the word, behind the pose's path if there are several."""
    poses = [other for other, kind in goal.items() if kind in known_types.GOAL_POSES]
    outer = [other for other in poses if not any(other.startswith(f"{p}.") for p in poses)]
    return word if len(outer) == 1 else f"{path} {word}"


def _remaining(feedback: Mapping[str, str]) -> RemainingField | None:
    """Return the first number of a feedback whose name says that it is what is left, or None."""
    for path, kind in feedback.items():
        name = path.rpartition(".")[2]
        if _NUMBERS.fullmatch(kind) and _REMAINING.search(name):
            return RemainingField(path, unit="m" if "distance" in name else "")
    return None


def word_of(name: str) -> str:
    """Return the word that is typed for an action or service: `/tb1/Go_Home` is go_home."""
    return name.rpartition("/")[2].lower().strip("_")


def title_of(name: str) -> str:
    """Return the title for an action or service: `/tb1/go_home` is Go home."""
    words = name.rpartition("/")[2].replace("_", " ").split()
    return " ".join(words).capitalize() or name
