"""The installed message class for each type of a bag, if its fields are those of the file.

mcap-ros2-support decodes without a class. It does not serve here: it refuses names such as
`MoveToShelf_FeedbackMessage`, so the feedback of every goal; it has no `wstring`, and reads a
`char` above 127 as negative.
"""

from __future__ import annotations

import hashlib
import re
from typing import Any

from archo_tui.recordings.replay.mcap_file import Unreadable
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

    def find_class(self, type_name: str, encoding: str, text: bytes) -> Any:
        """Return the class of `package/kind/Name`, or raise Unreadable.

        Definitions in another encoding than `ros2msg` are not compared.
        """
        given = b"\0".join((type_name.encode(), encoding.encode(), text))
        key = hashlib.sha256(given).digest()
        if key not in self._found:
            self._text_left -= len(given)
            if self._text_left < 0 or len(self._found) == _MAX_TYPES:
                raise Unreadable("too many types")
            try:
                self._found[key] = _find_class(type_name, encoding, text.decode(errors="replace"))
            except Unreadable as error:
                self._found[key] = str(error)
        found = self._found[key]
        if isinstance(found, str):
            raise Unreadable(found)
        return found


def _find_class(type_name: str, encoding: str, text: str) -> Any:
    parts = parse_type(type_name)
    made = None if parts is None else _load_class(parts)
    if parts is None or made is None:
        raise Unreadable(f"{type_name} is not installed here")
    root = f"{parts.package}/{parts.name}"
    if encoding == "ros2msg" and not _have_same_fields(
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
    """Return True if `root` and each message within it agree; theirs may contain themselves."""
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
    """Return the fields of each message of a definition, by `package/Name`; the first is `root`.

    Constants, defaults, and the bounds of strings and sequences are left out: they take no bytes.
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
    """Return a type as `package/Name`; one without a package is of that of its `owner`."""
    package = package_of(name if "/" in name else owner)
    return f"{package}/{base_name(name)}"
