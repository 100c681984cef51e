"""The Python classes of interfaces by their names, and the meaning of a service's answer.

The graph and files name the packages, so nothing but a package of interfaces is imported: any other
could do anything, as `import antigravity` opens a browser.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Any

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot_file.known_types import DIAGNOSTICS
from archo_tui.robot_file.model import RobotFile
from archo_tui.ros_names import KINDS, InterfaceType, base_name, package_of, parse_type

EMPTY = "structure_needs_at_least_one_member"  # The field that rosidl adds to an empty message.


def load(type_name: str) -> Any:
    """Import and return the class of a type such as `std_msgs/msg/String`.

    Only packages of interfaces are imported. The first import of a package may take long.

    Returns:
        The class; None if it is not installed here, or the name is no type.
    """
    parts = parse_type(type_name)
    if parts is None:
        return None
    module = f"{parts.package}.{parts.kind}"
    try:
        if module not in sys.modules and not _is_interfaces(parts.package):
            return None
        return getattr(importlib.import_module(module), parts.name)
    except (ImportError, AttributeError, ValueError):
        return None


def load_all(file: RobotFile) -> None:
    """Import the classes that a robot file names, and those that a STOP or a command usually has.

    Classes that are not installed are left out. The first import of a package takes long where the
    disk is slow, and on the ROS thread a STOP would wait for it. The types of the file's services
    are known on the graph only: most are of `std_srvs`, or of a package that has an action of the
    robot, too.
    """
    topics = [file.battery, file.motion, file.pose]
    types = {kind for topic in topics if topic is not None for kind in topic.types}
    types |= {gauge.type for gauge in file.gauges} | {goal.type for goal in file.goals}
    if file.diagnostics:
        types.add(DIAGNOSTICS)
    for name in types:
        load(name)
    for package in {"std_srvs", *(package_of(goal.type) for goal in file.goals)}:
        load(f"{package}/srv/Trigger")  # And with it all of the services.


def _is_interfaces(package: str) -> bool:
    """Return True for an installed package of interfaces, without importing it.

    Raises:
        ImportError: The package cannot be looked for.
        ValueError: The package cannot be looked for.
    """
    spec = importlib.util.find_spec(package)
    if spec is None or spec.submodule_search_locations is None:
        return False
    places = [*spec.submodule_search_locations, spec.origin or ""]
    # Any kind will do: a package of the user may add one kind to a built-in package.
    return any((Path(place) / kind).is_dir() for place in places for kind in KINDS)


def name_of(made: Any) -> str:
    """Return the type of an interface's class as `package/kind/Name`: `std_msgs/msg/String`."""
    package, kind, *_ = made.__module__.split(".")
    return str(InterfaceType(package, kind, made.__name__))


def load_nested(type_name: str) -> Any:
    """Return the class of a message that is a field, by its type as rosidl writes it.

    Args:
        type_name: `package/Name`: `std_msgs/Header`.

    Returns:
        The class; None if it is not installed here.
    """
    return load(f"{package_of(type_name)}/msg/{base_name(type_name)}")


def fields(message_class: Any) -> set[str]:
    """Return the names of a message class's own fields, not those of nested messages."""
    return set(message_class.get_fields_and_field_types()) - {EMPTY}


def _verdict_and_words(answer: Any) -> tuple[str, str]:
    """Return the names of the two fields of a service's answer that say if it worked, and why.

    The first is `success`, or else the only bool; the second `message`, or else the only string.
    Each is "" if there is no such field.
    """
    kinds = answer.get_fields_and_field_types()
    bools = [name for name, kind in kinds.items() if kind == "boolean"]
    texts = [name for name, kind in kinds.items() if kind == "string"]
    verdict = "success" if "success" in bools else bools[0] if len(bools) == 1 else ""
    words = "message" if "message" in texts else texts[0] if len(texts) == 1 else ""
    return verdict, words


def refuses(answer: Any) -> bool:
    """Return True if a service's answer says no: its `success`, or else its only bool, is false.

    False if it has neither.
    """
    verdict, _ = _verdict_and_words(answer)
    return bool(verdict) and not getattr(answer, verdict)


def says_more(answer: Any) -> bool:
    """Return True if a service's answer has other fields than its verdict and its message."""
    return bool(fields(answer) - set(_verdict_and_words(answer)))


def outcome_of(answer: Any) -> Outcome:
    """Return the outcome that a service's answer means, with the answer's message as its text.

    DONE or REFUSED by `success`, or else the only bool; NOT_CONFIRMED if there is none. Without a
    message the text is `done` or `failed`. The message may hold any characters.
    """
    verdict, words = _verdict_and_words(answer)
    if not verdict:
        return Outcome(Code.NOT_CONFIRMED, "answered, not confirmed")
    done, text = bool(getattr(answer, verdict)), getattr(answer, words, "")
    code = Code.DONE if done else Code.REFUSED
    return Outcome(code, text if isinstance(text, str) and text else ("done" if done else "failed"))
