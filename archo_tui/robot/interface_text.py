"""The definitions of interfaces as text, in the layout of `ros2 interface show`.

The text is that of the interface files: those from which the embedded engine makes its classes, or
those that are installed beside the Python packages of ROS 2. Files are read: call this on no thread
that others wait for.
"""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from archo_tui.embedded.idl_types import PRIMITIVES
from archo_tui.embedded.import_hook import InterfaceFinder
from archo_tui.regular_files import read
from archo_tui.robot import message_classes
from archo_tui.robot.definitions import field_lines
from archo_tui.ros_names import KINDS, InterfaceType, parse_type

_INDENT = " " * 4  # For each level of nesting.
_MAX_LINES = 5_000  # Of one text.
_DEEPEST = 50  # Levels of nesting.
_PARENTS = 5  # Levels from the folder of a Python package to the prefix with `share/`.
_SEPARATOR = "---"  # Between the parts of a service or an action.
_NOT_INSTALLED = "This type is not installed here."
_NOT_IN_A_FILE = "# Derived from the installed class: its file, with comments, was not found."
# A field: a type with or without its package, perhaps as an array, and a name.
_FIELD = re.compile(r"(?P<type>[A-Za-z]\w*(/\w+)?)(\[[^]]*\])?\s+[a-z]\w*")
_PARTS = {"msg": (), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


def definition_text(type_name: str) -> str | None:
    """Return the text of an interface's file, with nested types below their fields.

    Nested types are indented, and without comments. At most 5,000 lines are returned, and a line
    that says so.

    Args:
        type_name: `package/kind/Name`.

    Returns:
        The lines as one text; without a file, the fields of the installed class. None if neither is
        here, or the name is no type.
    """
    parts = parse_type(type_name)
    lines = None if parts is None else type_lines(parts)
    if parts is None or lines is None:
        return None
    every = list(islice(_with_nested(parts, lines, ()), _MAX_LINES + 1))
    if len(every) > _MAX_LINES:
        every[_MAX_LINES:] = [f"... and more: these are the first {_MAX_LINES} lines"]
    return "\n".join(every).rstrip()


def definitions_text(types: Sequence[str]) -> str:
    """Return the definitions of several types in one text, each below its name.

    For a type that is not installed, a line says so.
    """
    found = ((name, definition_text(name) or _NOT_INSTALLED) for name in types)
    return "\n\n".join(f"# {name}\n\n{text}" for name, text in found)


def names_in(package: str) -> list[str]:
    """Return the types that an installed package defines, sorted, as `package/kind/Name`.

    The list is empty if the package is not found.
    """
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
    """Yield the lines of a type, with those of nested types below their fields.

    Args:
        of: The type.
        lines: The lines of its file.
        above: The types that it is nested in, the outermost first; if any, comments are left out.
    """
    for line in lines:
        bare = line.partition("#")[0].rstrip() if above else line
        if bare or not above:
            yield f"{_INDENT * len(above)}{bare}".rstrip()
        nested = _nested_type(of.package, line)
        # No message contains itself; the files of a broken package might.
        if nested is not None and nested not in (of, *above) and len(above) < _DEEPEST:
            yield from _with_nested(nested, type_lines(nested) or [], (*above, of))


def _nested_type(package: str, line: str) -> InterfaceType | None:
    """Return the message type of the field in a line of a file; None for any other line.

    Args:
        package: The package of the file.
        line: The line.
    """
    found = _FIELD.match(line)
    if found is None or found["type"] in PRIMITIVES:
        return None
    before, _, name = found["type"].rpartition("/")
    return InterfaceType(before or package, "msg", name)


def type_lines(of: InterfaceType) -> list[str] | None:
    """Return the lines of a type's file, or, without a file, lines made from its installed class.

    None if neither is here.
    """
    for folder in _folders(of.package):
        try:
            text = read(folder / of.kind / f"{of.name}.{of.kind}").decode(errors="replace")
        except OSError:
            continue
        return [line.rstrip() for line in text.expandtabs(8).splitlines()]
    found = message_classes.load(str(of))
    return None if found is None else [_NOT_IN_A_FILE, *_derived_lines(of, found)]


def _derived_lines(of: InterfaceType, found: Any) -> list[str]:
    parts = [getattr(found, part) for part in _PARTS[of.kind]] or [found]
    lines: list[str] = []
    for part in parts:
        lines += [] if part is parts[0] else [_SEPARATOR]
        lines += [
            line
            for line in field_lines(part).splitlines()
            if not line.endswith(f" {message_classes.EMPTY}")
        ]
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
