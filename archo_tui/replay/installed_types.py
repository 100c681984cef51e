"""The installed message class for each type of a bag, if its fields are those of the file.

mcap-ros2-support decodes without a class. It does not serve here: it refuses names such as
`MoveToShelf_FeedbackMessage`, so the feedback of every goal; it has no `wstring`, and reads a
`char` above 127 as negative.
"""

from __future__ import annotations

import hashlib
import re
from typing import Any

from archo_tui.replay.chunks import Unreadable
from archo_tui.robot.messages.definitions import definition
from archo_tui.robot.messages.types import EMPTY, load_class
from archo_tui.ros_names import InterfaceType, base_name, package_of, parse_type

_MAX_TYPES = 2000  # Of a bag; each takes 0.1 ms to look for.
_MAX_TEXT = 16_000_000  # Bytes of all definitions of a bag.
_FEEDBACK = "_FeedbackMessage"
_SEPARATOR = re.compile(r"^=+[ \t]*$", re.MULTILINE)  # Between the messages of a definition.
_FIELD = re.compile(r"([\w/]+)(?:<=\d+)?(?:(\[)(<=)?(\d*)\])?[ \t]+(\w+)\b(?![ \t]*=)")
_ALIASES = {"char": "uint8", "Header": "std_msgs/Header"}
_PRIMITIVES = {"bool", "byte", "string", "wstring", "float32", "float64"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}

_Field = tuple[str, str, str]  # Element type, array form, name.
_Layout = dict[str, list[_Field]]  # The fields of each message by `package/Name`.


class InstalledTypes:
    """A cache of installed message classes by type and definition, for all files of one bag."""

    def __init__(self) -> None:
        self._found: dict[bytes, Any] = {}  # By a digest, since definitions may be large.
        self._text_left = _MAX_TEXT

    def find_class(self, type_name: str, encoding: str, text: str) -> Any:
        """Return the installed class of a type, if it has the same fields as in the file.

        Args:
            type_name: The type, as `package/kind/Name`.
            encoding: The schema's encoding; definitions other than `ros2msg` are not compared.
            text: The definition in the file.

        Raises:
            Unreadable: The type is not installed or has other fields, or the bag has more than
                2,000 types or 16 MB of definitions.
        """
        given = "\0".join((type_name, encoding, text)).encode()
        key = hashlib.sha256(given).digest()
        if key not in self._found:
            self._text_left -= len(given)
            if self._text_left < 0 or len(self._found) == _MAX_TYPES:
                raise Unreadable("too many types")
            try:
                self._found[key] = _find_class(type_name, encoding, text)
            except Unreadable as error:
                self._found[key] = str(error)
        found = self._found[key]
        if isinstance(found, str):
            raise Unreadable(found)
        return found


def _find_class(type_name: str, encoding: str, text: str) -> Any:
    """Return the class for `package/kind/Name`.

    Raises:
        Unreadable: It is not installed, or its fields are not those of a `ros2msg` definition.
    """
    parts = parse_type(type_name)
    made = None if parts is None else _load_class(parts)
    if parts is None or made is None:
        raise Unreadable(f"{type_name} is not installed here")
    if encoding != "ros2msg":  # Other encodings cannot be compared.
        return made
    root = f"{parts.package}/{parts.name}"
    if not _have_same_fields(
        _parse_layout(definition(made), root), _parse_layout(text, root), root
    ):
        raise Unreadable(f"{type_name} has other fields here than in the file")
    return made


def _load_class(parts: InterfaceType) -> Any:
    """Return the class of a message or of an action's feedback message; None if not installed."""
    made = load_class(str(parts))
    if made is None and parts.kind == "action" and parts.name.endswith(_FEEDBACK):
        action = load_class(str(parts).removesuffix(_FEEDBACK))
        made = getattr(getattr(action, "Impl", None), "FeedbackMessage", None)
    return made if hasattr(made, "get_fields_and_field_types") else None


def _have_same_fields(ours: _Layout, theirs: _Layout, root: str) -> bool:
    """Return True if `root`, and each message within it, has the same fields in both layouts.

    Their names, types, array lengths and order have to be equal.

    Args:
        ours: The installed layout, whose messages contain none of themselves.
        theirs: The layout in the file.
        root: The `package/Name` of the outermost message.
    """
    wanted, seen = [root], set[str]()
    while wanted:
        name = wanted.pop()
        if name in seen:
            continue
        seen.add(name)
        if name not in theirs or ours[name] != theirs[name]:
            return False
        wanted += [kind for kind, _, _ in ours[name] if "/" in kind]
    return True


def _parse_layout(text: str, root: str) -> _Layout:
    """Return the fields of each message of a definition, by `package/Name`.

    Constants, defaults, and the bounds of strings and sequences are left out: they take no bytes.

    Args:
        text: The definition of a message, followed by those of the messages in it.
        root: The `package/Name` of the first.
    """
    found: _Layout = {}
    for number, part in enumerate(_SEPARATOR.split(text)):
        name, body = root, part
        if number:
            head, _, body = part.lstrip().partition("\n")
            name = _full_name(head.removeprefix("MSG:").strip(), root)
        found.setdefault(name, _parse_fields(body, name))
    return found


def _parse_fields(text: str, owner: str) -> list[_Field]:
    found = []
    for line in text.splitlines():
        field = _FIELD.match(line.strip())
        if field and field[5] != EMPTY:
            kind = _ALIASES.get(field[1], field[1])
            if kind not in _PRIMITIVES:
                kind = _full_name(kind, owner)
            size = "" if field[3] else field[4] or ""
            found.append((kind, f"[{size}]" if field[2] else "", field[5]))
    return found


def _full_name(name: str, owner: str) -> str:
    """Return a message type as `package/Name`.

    Args:
        name: The type, as `package/Name`, `package/msg/Name`, or `Name` alone.
        owner: A type of the package that is meant if `name` has none.
    """
    package = package_of(name if "/" in name else owner)
    return f"{package}/{base_name(name)}"
