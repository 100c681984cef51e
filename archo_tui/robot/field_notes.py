"""The notes in the definition of a type: the units of fields, and the names of their values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

from archo_tui.robot.interface_text import type_lines
from archo_tui.ros_names import parse_type

# Units that may stand anywhere in a comment where a unit is expected.
_SYMBOLS = {
    "%", "m", "mm", "cm", "km", "m/s", "km/h", "m/s^2", "m/s²", "m^2", "m²", "m^3", "m³", "s", "ms",
    "us", "µs", "ns", "min", "h", "Hz", "kHz", "MHz", "rad", "mrad", "rad/s", "rad/s^2", "rad/s²",
    "deg", "deg/s", "°", "°/s", "°C", "K", "V", "mV", "A", "mA", "Ah", "mAh", "W", "kW", "Wh",
    "kWh", "J", "N", "Nm", "N·m", "N*m", "kg", "g", "Pa", "hPa", "kPa", "bar", "lx", "lux", "T",
    "uT", "µT", "dB", "dBm", "rpm", "px", "pixels", "B", "kB", "MB",
}  # fmt: skip
# Of these, those that begin a remark in no sentence: `A flag` speaks of no amperes.
_FIRST = _SYMBOLS - {"A", "B", "K", "N", "T", "J", "W", "h", "g", "min"}
_WORDS = {
    "volt": "V", "volts": "V", "amps": "A", "ampere": "A", "amperes": "A", "meter": "m",
    "meters": "m", "metre": "m", "metres": "m", "seconds": "s", "sec": "s", "milliseconds": "ms",
    "nanoseconds": "ns", "radian": "rad", "radians": "rad", "degrees": "°", "celsius": "°C",
    "hertz": "Hz", "newton": "N", "newtons": "N", "pascal": "Pa", "pascals": "Pa", "tesla": "T",
    "lux": "lx", "percent": "%", "kilograms": "kg", "watts": "W", "pixels": "px",
}  # fmt: skip
_BRACKETS = re.compile(r"[\[(]([^])]{1,20})[])]")
_IN = re.compile(r"\bin (degrees celsius|\S+)", re.IGNORECASE)
_FIELD = re.compile(r"[A-Za-z][\w/]*(?:<=\d+)?(?:\[[^]]*\])?\s+([a-z]\w*)\s*([^#]*)(?:#(.*))?")
_CONSTANT = re.compile(r"([a-z]\w*)\s+([A-Z]\w*)\s*=\s*([^#]*)")
_INTEGER = re.compile(r"(?:u?int\d+|byte|char)")


class FieldNotes(NamedTuple):
    """The notes on the fields of one type.

    Attributes:
        units: The units by field, for those fields whose comment names one.
        names: The names of a field's values by field, where the type has constants for them:
            `{"status": {0: "UNKNOWN"}}`.
    """

    units: Mapping[str, str] = {}
    names: Mapping[str, Mapping[int, str]] = {}


@lru_cache(256)
def notes_of(type_name: str) -> FieldNotes:
    """Return the notes on a type, such as `sensor_msgs/msg/BatteryState`; empty if it is not found.

    The first call for a type reads its interface file.
    """
    parts = parse_type(type_name)
    lines = None if parts is None else type_lines(parts)
    return FieldNotes() if lines is None else read_notes(lines)


def read_notes(lines: Sequence[str]) -> FieldNotes:
    """Return the notes in the lines of a .msg file: units in comments, and constants."""
    units, kinds = {}, {}
    for line in lines:
        found = _FIELD.match(line)
        if found is not None:
            kinds[found[1]] = line.split(maxsplit=1)[0]
            unit = unit_in(found[3] or "")
            if unit:
                units[found[1]] = unit
    return FieldNotes(units, _names(kinds, list(_constants(lines))))


def unit_in(comment: str) -> str:
    """Return the unit that the comment behind a field names, as a symbol: `m/s`; "" for none.

    The unit stands in brackets (`[rad]`), first in a part of the comment (`% of full`), or behind
    `in` (`in Volts`), looked for in this order. First in a part, a symbol that is also a word (`A`)
    counts only if it is all of that part.
    """
    for inside in _BRACKETS.findall(comment):
        if unit := _unit(inside.strip()):
            return unit
    for part in re.split(r"[,;:(]", comment):
        words = part.strip().rstrip(".").split()
        if words and (words[0] in _FIRST or (len(words) == 1 and words[0] in _SYMBOLS)):
            return words[0]
    for behind in _IN.findall(comment):
        if unit := _unit(behind.rstrip(".,;:)").split()[-1]):
            return unit
    return ""


def _unit(text: str) -> str:
    return text if text in _SYMBOLS else _WORDS.get(text.lower(), "")


def _constants(lines: Sequence[str]) -> Iterator[tuple[str, str, int]]:
    """Yield type, name and value of each constant of an integer type."""
    for line in lines:
        found = _CONSTANT.match(line)
        if found is not None and _INTEGER.fullmatch(found[1]):
            try:
                yield found[1], found[2], int(found[3].strip(), 0)
            except ValueError:
                continue


def _names(
    kinds: Mapping[str, str], constants: Sequence[tuple[str, str, int]]
) -> dict[str, dict[int, str]]:
    """Return the names of each field's values.

    A constant belongs to the field of the same type with whose name its own begins, the longest
    such field, and loses that beginning. All other constants of a type belong to the only field of
    that type, if there is only one and it has no names yet. The first name of a value counts.

    Args:
        kinds: The type of each field, by the field's name.
        constants: Type, name and value of each constant.
    """
    prefixed: dict[str, dict[int, str]] = {}
    others: dict[str, dict[int, str]] = {}
    longest_first = sorted(kinds, key=len, reverse=True)
    for kind, name, value in constants:
        owner = next(
            (f for f in longest_first if kinds[f] == kind and name.startswith(f"{f.upper()}_")), ""
        )
        if owner:
            prefixed.setdefault(owner, {}).setdefault(value, name[len(owner) + 1 :])
        else:
            others.setdefault(kind, {}).setdefault(value, name)
    for kind, names in others.items():
        fields = [field for field in kinds if kinds[field] == kind]
        if len(fields) == 1 and fields[0] not in prefixed:
            prefixed[fields[0]] = names
    return prefixed
