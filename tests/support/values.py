"""Random values of every field type, as a person would write them; and messages as such values."""

from __future__ import annotations

import contextlib
import importlib
import math
import random
import re
import struct
from pathlib import Path
from typing import Any

from archo_tui.robot.messages.types import EMPTY, load_class

_LIST = re.compile(r"sequence<(.+?)(?:, (\d+))?>|(.+)\[(\d+)\]")
_TEXTS = (
    *("", " ", "a", "map", "yes", "no", "on", "off", "y", "null", "~", "true", "False", "None"),
    *("12", "1e3", "010", "0x1F", "0o7", "1_0", "1:30", ".inf", ".nan", "nan", "-", "=", "<<"),
    *(
        "it's",
        'say "so"',
        "a: b",
        "a #b",
        "[1]",
        "{a: b}",
        "new\nline",
        "tab\t.",
        "\\n",
        "$HOME `x`",
    ),
    *("é", "日本語", "\u2028", "\x7f\x85", "😀", "%s", "!x", "&a", "*a", "@", " lead", "trail "),
    *("2001-01-01", "a,b", "?", "? a", "- a", "|", ">", "'", '"', "a\rb"),
)
_NUMBERS = (0.0, -0.0, 1.0, -1.5, 1e16, -1e-7, 1e300, 0.1, 5e-324, math.inf, -math.inf, math.nan)

_ROOT = Path(__file__).parent.parent.parent
_PACKAGES = (
    *("action_msgs", "archo_interfaces", "builtin_interfaces", "depot_interfaces"),
    *("lifecycle_msgs", "rcl_interfaces", "rosgraph_msgs", "service_msgs", "std_msgs"),
    *("std_srvs", "type_description_interfaces", "unique_identifier_msgs"),
)
_PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


def value_of(kind: str, chance: random.Random) -> Any:
    """A value for a field of that type; at its limits more often than not."""
    found = _LIST.fullmatch(kind)
    if found is not None:
        count = int(found[4]) if found[4] else chance.randint(0, int(found[2] or 5))
        return [value_of(found[1] or found[3], chance) for _ in range(count)]
    if "/" in kind:
        package, name = kind.split("/")
        return values_of(load_class(f"{package}/msg/{name}"), chance)
    if "string" in kind:
        bound = re.search(r"\d+", kind)
        return chance.choice(_TEXTS)[: int(bound[0]) if bound else None]
    if kind == "boolean":
        return chance.random() < 0.5
    if kind in ("float", "double"):
        number = chance.choice([*_NUMBERS, chance.uniform(-1e6, 1e6)])
        return as_float32(number) if kind == "float" else number
    bits = 8 if kind == "octet" else int(kind.lstrip("uint"))
    low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if kind[0] == "i" else (0, 2**bits - 1)
    return chance.choice([low, high, 0, chance.randint(low, high)])


def values_of(message_class: Any, chance: random.Random) -> dict[str, Any]:
    """Values for all fields of a message."""
    kinds = message_class.get_fields_and_field_types()
    return {name: value_of(kind, chance) for name, kind in kinds.items() if name != EMPTY}


def as_float32(number: float) -> float:
    """As four bytes hold it; what they have no room for is made zero."""
    if math.isfinite(number) and abs(number) > 3e38:
        return 0.0
    rounded: float = struct.unpack("f", struct.pack("f", number))[0]
    return rounded


def told(value: Any) -> Any:
    """A message, or what it holds, as values that can be compared: nan is equal to nan."""
    if hasattr(value, "get_fields_and_field_types"):
        return {
            n: told(getattr(value, n)) for n in value.get_fields_and_field_types() if n != EMPTY
        }
    if isinstance(value, dict):
        return {name: told(item) for name, item in value.items()}
    if isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, bytes):
        return value[0]
    if isinstance(value, float):
        return repr(value)
    return [told(item) for item in (value.tolist() if hasattr(value, "tolist") else value)]


def installed() -> dict[str, Any]:
    """The classes of all messages, requests and parts of actions that can be made here, by name."""
    found: dict[str, Any] = {}
    for package in _PACKAGES:
        for kind, parts in _PARTS.items():
            for name in _names(package, kind):
                loaded = load_class(f"{package}/{kind}/{name}")
                for part in parts:
                    made = getattr(loaded, part, None) if part else loaded
                    if hasattr(made, "get_fields_and_field_types"):
                        found[f"{package}/{kind}/{name} {part}".strip()] = made
    return found


def _names(package: str, kind: str) -> set[str]:
    """Those with a file here, of which the embedded engine makes classes; and those of ROS."""
    files = [
        path
        for share in ("archo_tui/ros/embedded/share", "tests/share")
        for path in (_ROOT / share / package / kind).glob("*")
    ]
    own = (_ROOT / "interfaces" / kind).glob("*") if package == "archo_interfaces" else ()
    names = {path.stem for path in (*files, *own)}
    with contextlib.suppress(ImportError):
        names |= set(dir(importlib.import_module(f"{package}.{kind}")))
    return names
