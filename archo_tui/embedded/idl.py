"""Reads ROS interface files (.msg, .srv, .action) into plain descriptions.

The grammar is the one of ROS 2's "About interfaces": `type name [default]`, `type NAME=constant`,
`#` comments, arrays `[]`, `[N]`, `[<=N]`, bounded strings `string<=N`, sections parted by `---`.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import yaml

# name -> (lowest, highest) of the integer types; `char` is uint8 in ROS 2
INTEGERS = {
    f"{sign}int{bits}": (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
} | {"char": (0, 255)}
FLOATS = ("float32", "float64")
# element types that rosidl keeps in array.array, with array's type codes
TYPE_CODES = {
    "int8": "b", "uint8": "B", "char": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip
# as rosidl's `get_fields_and_field_types` calls them
_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8"} | {
    "float32": "float",
    "float64": "double",
}
PRIMITIVES = {*INTEGERS, *FLOATS, "bool", "byte", "string", "wstring"}

_FIELD = re.compile(
    r"(?P<type>[A-Za-z][\w/]*)(?:<=(?P<bound>\d+))?(?P<array>\[(?:(?P<upto><=)?(?P<size>\d+))?\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?:(?P<constant>=)\s*(?P<value>.*)|(?P<default>\S.*))?"
)


class InterfaceError(ImportError):
    """An interface file that cannot be used; the message starts with `file:line:`."""


class FieldType(NamedTuple):
    """The type of a field: a primitive or `package/Name`, and its array form."""

    base: str
    string_bound: int | None = None
    is_array: bool = False
    fixed_size: int | None = None
    upper_bound: int | None = None

    def __str__(self) -> str:
        text = _IDL_NAMES.get(self.base, self.base)
        if self.string_bound is not None:
            text += f"<{self.string_bound}>"
        if self.fixed_size is not None:
            return f"{text}[{self.fixed_size}]"
        if self.is_array:
            bound = "" if self.upper_bound is None else f", {self.upper_bound}"
            return f"sequence<{text}{bound}>"
        return text


class Field(NamedTuple):
    """One field: its type, name, default (None when the file gives none) and line."""

    type: FieldType
    name: str
    default: object
    line: int


class Section(NamedTuple):
    """The fields and constants between two `---` lines."""

    path: Path
    fields: tuple[Field, ...]
    constants: tuple[tuple[str, object], ...]


def parse(path: Path, package: str) -> list[Section]:
    """Read one interface file: one section for .msg, two for .srv, three for .action.

    Types without a package are looked for in `package`, as ROS does.
    Raises InterfaceError with file and line.
    """
    sections: list[tuple[list[Field], list[tuple[str, object]]]] = [([], [])]
    for number, raw in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        line = _without_comment(raw).strip()
        if line == "---":
            sections.append(([], []))
        elif line:
            _parse_line(line, package, f"{path}:{number}", number, *sections[-1])
    wanted = {".msg": 1, ".srv": 2, ".action": 3}[path.suffix]
    if len(sections) != wanted:
        raise InterfaceError(
            f"{path}:1: a {path.suffix} file has {wanted - 1} '---' lines, this one has "
            f"{len(sections) - 1}"
        )
    return [Section(path, tuple(fields), tuple(constants)) for fields, constants in sections]


def _parse_line(
    line: str,
    package: str,
    where: str,
    number: int,
    fields: list[Field],
    constants: list[tuple[str, object]],
) -> None:
    match = _FIELD.fullmatch(line)
    if match is None:
        raise InterfaceError(f"{where}: not 'type name': {line!r}")
    base = match["type"]
    if base not in PRIMITIVES:
        if base == "Header":
            base = "std_msgs/Header"
        parts = [part for part in base.split("/") if part != "msg"]
        base = "/".join(parts if len(parts) > 1 else [package, *parts])
    kind = FieldType(
        base=base,
        string_bound=int(match["bound"]) if match["bound"] else None,
        is_array=match["array"] is not None,
        fixed_size=int(match["size"]) if match["size"] and not match["upto"] else None,
        upper_bound=int(match["size"]) if match["upto"] else None,
    )
    if match["constant"]:
        constants.append((match["name"], _literal(match["value"], kind, where)))
        return
    if any(field.name == match["name"] for field in fields):
        raise InterfaceError(f"{where}: a second field named {match['name']!r}")
    default = _literal(match["default"], kind, where) if match["default"] else None
    fields.append(Field(kind, match["name"], default, number))


def _literal(text: str, kind: FieldType, where: str) -> object:
    """The Python value of a constant or default written in an interface file."""
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        value = text
    if kind.is_array:
        return value
    if kind.base in FLOATS and isinstance(value, int):
        return float(value)
    if kind.base in ("string", "wstring"):
        return value if isinstance(value, str) else text
    if kind.base == "bool":
        return bool(value)
    if kind.base == "byte" and isinstance(value, int):
        return bytes([value])
    if kind.base in INTEGERS and isinstance(value, str):
        try:
            return int(value, 0)
        except ValueError:
            raise InterfaceError(f"{where}: {text!r} is not of type {kind.base}") from None
    return value


def _without_comment(line: str) -> str:
    """The line up to `#`, unless that stands inside quotes."""
    quote = ""
    for index, char in enumerate(line):
        if quote:
            quote = "" if char == quote else quote
        elif char in "\"'":
            quote = char
        elif char == "#":
            return line[:index]
    return line
