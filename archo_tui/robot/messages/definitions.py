"""The definitions of interfaces as text: as `ros2 interface show` has them, and for recordings.

The text is that of the interface files: those from which the embedded engine makes its classes, or
those that are installed beside the Python packages of ROS 2. Files are read: call this on no thread
that others wait for.
"""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

from archo_tui.base.regular_files import read
from archo_tui.robot.messages.types import element_of, kinds, load_class, load_nested, ros2msg_type
from archo_tui.ros.embedded.idl import PRIMITIVES
from archo_tui.ros.embedded.import_hook import InterfaceFinder
from archo_tui.ros.names import KINDS, InterfaceType, parse_type

_INDENT = " " * 4  # For each level of nesting.
_MAX_LINES = 5_000  # Of one text.
_DEEPEST = 50  # Levels of nesting.
_PARENTS = 5  # Levels from the folder of a Python package to the prefix with `share/`.
_NOT_INSTALLED = "This type is not installed here."
_NOT_IN_A_FILE = "# Derived from the installed class: its file, with comments, was not found."
# A field: a type with or without its package, perhaps as an array, and a name.
_FIELD = re.compile(
    r"(?P<type>[A-Za-z]\w*(?:/\w+)?)(?P<more>(?:<=\d+)?(?:\[[^]]*\])?)\s+(?P<name>[a-z]\w*)\b"
)
_CONSTANT = re.compile(r"([a-z]\w*)\s+([A-Z]\w*)\s*=\s*([^#]*)")
_INTEGER = re.compile(r"(?:u?int\d+|byte|char)")
_PARTS = {"msg": (), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


def definition(kind: Any) -> str:
    """Return a message class and all nested ones as text (mcap.dev/spec/registry#ros2msg)."""
    parts, wanted, seen = [_field_lines(kind)], list(_nested_names(kind)), set[str]()
    while wanted:
        name = wanted.pop(0)
        if name not in seen:
            seen.add(name)
            inner = load_nested(name)
            parts.append(f"{'=' * 80}\nMSG: {name}\n{_field_lines(inner)}")
            wanted += _nested_names(inner)
    return "".join(parts)


def _field_lines(kind: Any) -> str:
    """Return type and name of each field, one a line, also of the one in an empty message."""
    types = kind.get_fields_and_field_types()
    return "".join(f"{ros2msg_type(types[name])} {name}\n" for name in types)


def _nested_names(kind: Any) -> list[str]:
    types = kind.get_fields_and_field_types().values()
    return [bare for bare in (element_of(each) or each for each in types) if "/" in bare]


def definition_text(type_name: str) -> str | None:
    """Return the text of an interface's file, with nested types indented below their fields."""
    parts = parse_type(type_name)
    lines = None if parts is None else _type_lines(parts)
    if parts is None or lines is None:
        return None
    every = list(islice(_with_nested(parts, lines, ()), _MAX_LINES + 1))
    if len(every) > _MAX_LINES:
        every[_MAX_LINES:] = [f"... and more: these are the first {_MAX_LINES} lines"]
    return "\n".join(every).rstrip()


def definitions_text(types: Sequence[str]) -> str:
    """Return the definitions of several types in one text, each below its name."""
    found = ((name, definition_text(name) or _NOT_INSTALLED) for name in types)
    return "\n\n".join(f"# {name}\n\n{text}" for name, text in found)


def names_in(package: str) -> list[str]:
    """Return the types that an installed package defines, sorted, as `package/kind/Name`."""
    found = {
        f"{package}/{kind}/{path.stem}"
        for folder in _folders(package)
        for kind in KINDS
        for path in folder.glob(f"{kind}/*.{kind}")
    }
    return sorted(found)


def _with_nested(
    of: InterfaceType, lines: list[str], above: tuple[InterfaceType, ...]
) -> Iterator[str]:
    """Yield the lines of a type, without comments if it is nested in others (`above`)."""
    for line in lines:
        bare = line.partition("#")[0].rstrip() if above else line
        if bare or not above:
            yield f"{_INDENT * len(above)}{bare}".rstrip()
        nested = _nested_type(of.package, line)
        # No message contains itself; the files of a broken package might.
        if nested is not None and nested not in (of, *above) and len(above) < _DEEPEST:
            yield from _with_nested(nested, _type_lines(nested) or [], (*above, of))


def _nested_type(package: str, line: str) -> InterfaceType | None:
    found = _FIELD.match(line)
    if found is None or found["type"] in PRIMITIVES:
        return None
    before, _, name = found["type"].rpartition("/")
    return InterfaceType(before or package, "msg", name)


def _type_lines(of: InterfaceType) -> list[str] | None:
    """Return the lines of a type's file, or lines made from its class; None if neither is here."""
    for folder in _folders(of.package):
        try:
            text = read(folder / of.kind / f"{of.name}.{of.kind}").decode(errors="replace")
        except OSError:
            continue
        return [line.rstrip() for line in text.expandtabs(8).splitlines()]
    found = load_class(str(of))
    if found is None:
        return None
    parts = [getattr(found, part) for part in _PARTS[of.kind]] or [found]
    lines = [_NOT_IN_A_FILE]
    for part in parts:
        lines += [] if part is parts[0] else ["---"]
        lines += [f"{ros2msg_type(kind)} {name}" for name, kind in kinds(part).items()]
    return lines


def _folders(package: str) -> list[Path]:
    """Return the folders with a package's msg/, srv/ and action/, in the order of search."""
    for finder in sys.meta_path:
        if isinstance(finder, InterfaceFinder):
            return finder.folders(package)
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        spec = None
    # pip and colcon install `share/` some folders above the Python package.
    prefixes = [
        parent
        for place in (spec and spec.submodule_search_locations) or ()
        for parent in list(Path(place).parents)[:_PARENTS]
    ]
    prefixes += map(Path, filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)))
    shares = dict.fromkeys(prefix / "share" / package for prefix in prefixes)
    return [share for share in shares if any((share / kind).is_dir() for kind in KINDS)]


ValueNames = Mapping[str, Mapping[int, str]]  # The names of a field's values, by field.


@lru_cache(256)
def value_names(type_name: str) -> ValueNames:
    """Return the names that a type's constants give to values: `{"status": {0: "UNKNOWN"}}`."""
    parts = parse_type(type_name)
    return read_names((None if parts is None else _type_lines(parts)) or ())


def read_names(lines: Sequence[str]) -> ValueNames:
    """Return the names of values in the lines of a .msg file.

    A constant belongs to the field of its type whose name its own begins with, and loses that
    beginning. Others belong to the only field of their type, if it has no such constants.
    """
    found = filter(None, map(_FIELD.match, lines))
    fields = {field["name"]: field["type"] + field["more"] for field in found}
    longest_first = sorted(fields, key=len, reverse=True)
    named: dict[str, dict[int, str]] = {}
    others: dict[str, dict[int, str]] = {}
    for kind, name, value in _constants(lines):
        of_kind = [field for field in longest_first if fields[field] == kind]
        owner = next((f for f in of_kind if name.startswith(f"{f.upper()}_")), "")
        if owner:
            named.setdefault(owner, {}).setdefault(value, name[len(owner) + 1 :])
        else:
            others.setdefault(kind, {}).setdefault(value, name)
    for kind, names in others.items():
        of_kind = [field for field in fields if fields[field] == kind]
        if len(of_kind) == 1 and of_kind[0] not in named:
            named[of_kind[0]] = names
    return named


def _constants(lines: Sequence[str]) -> Iterator[tuple[str, str, int]]:
    """Yield type, name and value of each constant of an integer type."""
    for line in lines:
        found = _CONSTANT.match(line)
        if found is not None and _INTEGER.fullmatch(found[1]):
            try:
                yield found[1], found[2], int(found[3].strip(), 0)
            except ValueError:
                continue
