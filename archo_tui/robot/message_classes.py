"""The Python class of an interface that the graph or a file names, and what its messages hold.

Nothing is imported for it but a package of interfaces: `import antigravity` opens a browser.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Any

from archo_tui.robot.outcome import Code, Outcome

_KINDS = ("msg", "srv", "action")
EMPTY = "structure_needs_at_least_one_member"  # rosidl's filler of an empty message


def load(type_name: str) -> Any:
    """The class of "package/kind/Name", or None when it is not installed here."""
    try:
        package, kind, name = type_name.split("/")
        if f"{package}.{kind}" not in sys.modules and not _is_interfaces(package, kind):
            return None
        return getattr(importlib.import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError, ValueError):
        return None


def _is_interfaces(package: str, kind: str) -> bool:
    """True for a package of interfaces; nothing is imported to know it. Raises as `import` does."""
    if not package.isidentifier() or kind not in _KINDS:
        return False
    spec = importlib.util.find_spec(package)
    if spec is None or spec.submodule_search_locations is None:
        return False
    places = [*spec.submodule_search_locations, spec.origin or ""]
    # any kind's: of the user's own package the other kinds may be the built-in one's
    return any((Path(place) / each).is_dir() for place in places for each in _KINDS)


def name_of(made: Any) -> str:
    """ "package/kind/Name" of a class."""
    package, kind, *_ = made.__module__.split(".")
    return f"{package}/{kind}/{made.__name__}"


def fields(message_class: Any) -> set[str]:
    """The names of a message's fields."""
    return set(message_class.get_fields_and_field_types()) - {EMPTY}


def _read(answer: Any) -> tuple[str, str]:
    """Return the fields of a service's answer that say yes or no, and why; empty: it has none.

    They are `success`, else its only bool, and `message`, else its only string.
    """
    kinds = answer.get_fields_and_field_types()
    bools = [name for name, kind in kinds.items() if kind == "boolean"]
    texts = [name for name, kind in kinds.items() if kind == "string"]
    verdict = "success" if "success" in bools else bools[0] if len(bools) == 1 else ""
    words = "message" if "message" in texts else texts[0] if len(texts) == 1 else ""
    return verdict, words


def refuses(answer: Any) -> bool:
    """True when a service's answer says no."""
    verdict, _ = _read(answer)
    return bool(verdict) and not getattr(answer, verdict)


def says_more(answer: Any) -> bool:
    """Return True when a service's answer has fields that `outcome_of` leaves out."""
    return bool(fields(answer) - set(_read(answer)))


def outcome_of(answer: Any) -> Outcome:
    """Return whether a service's answer says yes, and its words."""
    verdict, words = _read(answer)
    if not verdict:
        return Outcome(Code.NOT_CONFIRMED, "answered, not confirmed")
    done, said = bool(getattr(answer, verdict)), getattr(answer, words, "")
    code = Code.DONE if done else Code.REFUSED
    return Outcome(code, said if isinstance(said, str) and said else ("done" if done else "failed"))
