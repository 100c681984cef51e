"""The Python classes of interfaces by their names, and the meaning of a service's answer.

The graph and files name the packages, so nothing but a package of interfaces is imported: another
one could do anything, as `import antigravity` opens a browser.
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
    """Return the class of a type such as `std_msgs/msg/String`; None if it is not installed."""
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
    """Load the classes that a robot file names, and those that a STOP or a command usually has.

    The first import of a package takes long where the disk is slow. On the ROS thread a STOP would
    wait for it. The services of a file have their types on the graph only: most are of `std_srvs`,
    or of a package that has an action of the robot, too.
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
    """Return True for a package of interfaces, without importing it.

    Raises:
        ImportError: The package cannot be looked for.
        ValueError: The same.
    """
    spec = importlib.util.find_spec(package)
    if spec is None or spec.submodule_search_locations is None:
        return False
    places = [*spec.submodule_search_locations, spec.origin or ""]
    # Any kind will do: a package of the user may add one kind to a built-in package.
    return any((Path(place) / kind).is_dir() for place in places for kind in KINDS)


def name_of(made: Any) -> str:
    """Return the type of a class, such as `std_msgs/msg/String`."""
    package, kind, *_ = made.__module__.split(".")
    return str(InterfaceType(package, kind, made.__name__))


def load_nested(type_name: str) -> Any:
    """Return the class of a message in a field, whose type is `std_msgs/Header`, or None."""
    return load(f"{package_of(type_name)}/msg/{base_name(type_name)}")


def fields(message_class: Any) -> set[str]:
    """Return the names of a message's fields."""
    return set(message_class.get_fields_and_field_types()) - {EMPTY}


def _read(answer: Any) -> tuple[str, str]:
    """Return the fields of a service's answer with the verdict and with the words; "" for none.

    They are `success`, or else the only bool, and `message`, or else the only string.
    """
    kinds = answer.get_fields_and_field_types()
    bools = [name for name, kind in kinds.items() if kind == "boolean"]
    texts = [name for name, kind in kinds.items() if kind == "string"]
    verdict = "success" if "success" in bools else bools[0] if len(bools) == 1 else ""
    words = "message" if "message" in texts else texts[0] if len(texts) == 1 else ""
    return verdict, words


def refuses(answer: Any) -> bool:
    """Return True if a service's answer says no."""
    verdict, _ = _read(answer)
    return bool(verdict) and not getattr(answer, verdict)


def says_more(answer: Any) -> bool:
    """Return True if a service's answer has fields that `outcome_of` leaves out."""
    return bool(fields(answer) - set(_read(answer)))


def outcome_of(answer: Any) -> Outcome:
    """Return the outcome that a service's answer means, with the answer's words."""
    verdict, words = _read(answer)
    if not verdict:
        return Outcome(Code.NOT_CONFIRMED, "answered, not confirmed")
    done, text = bool(getattr(answer, verdict)), getattr(answer, words, "")
    code = Code.DONE if done else Code.REFUSED
    return Outcome(code, text if isinstance(text, str) and text else ("done" if done else "failed"))
