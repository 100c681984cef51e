"""The class for a type that a file names: installed, and with the fields that the file means.

mcap-ros2-support decodes without a class, but refuses names such as `MoveToShelf_FeedbackMessage`,
so the feedback of every goal; it has no `wstring`, and reads a `char` above 127 as negative.
"""

from __future__ import annotations

import hashlib
import re
from typing import Any

from archo_tui.recording.definitions import definition
from archo_tui.replay.chunks import Unreadable
from archo_tui.robot import message_classes

_MOST_TYPES = 2000  # of a bag: it takes 0.1 ms to see that one is not installed
_MOST_TEXT = 16_000_000  # bytes of all the definitions that are compared
_TYPE = re.compile(r"([a-z][a-z0-9_]{0,99})/(msg|srv|action)/([A-Za-z][A-Za-z0-9_]{0,99})")
_FEEDBACK = "_FeedbackMessage"
_RULE = re.compile(r"^=+[ \t]*$", re.MULTILINE)  # between one message's fields and the next one's
_FIELD = re.compile(r"([\w/]+)(?:<=\d+)?(?:(\[)(<=)?(\d*)\])?[ \t]+(\w+)\b(?![ \t]*=)")
_NAMES = {"char": "uint8", "Header": "std_msgs/Header"}
_PRIMITIVES = {"bool", "byte", "string", "wstring", "float32", "float64"} | {
    f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)
}

_Field = tuple[str, str, str]  # type of an element, array form, name
_Layout = dict[str, list[_Field]]  # the fields of each message, by `package/Name`


class ReceivedTypes:
    """The classes for the types of a bag, whose files repeat them."""

    def __init__(self) -> None:
        self._found: dict[bytes, Any] = {}  # by a digest: the definitions themselves may be large
        self._left = _MOST_TEXT

    def find(self, type_name: str, encoding: str, text: str) -> Any:
        """The class for a type; `text` is its definition. Raises Unreadable with what is wrong."""
        given = "\0".join((type_name, encoding, text)).encode()
        key = hashlib.sha256(given).digest()
        if key not in self._found:
            self._left -= len(given)
            if self._left < 0 or len(self._found) == _MOST_TYPES:
                raise Unreadable("too many types")
            try:
                self._found[key] = _find(type_name, encoding, text)
            except Unreadable as error:
                self._found[key] = str(error)
        found = self._found[key]
        if isinstance(found, str):
            raise Unreadable(found)
        return found


def _find(type_name: str, encoding: str, text: str) -> Any:
    """The class for `package/kind/Name`, whose definition in the file is `text`.

    Raises Unreadable when it is not installed, or with other fields.
    """
    found = _TYPE.fullmatch(type_name)
    made = _load(*found.groups()) if found else None
    if made is None:
        raise Unreadable(f"{type_name} is not installed here")
    if encoding != "ros2msg":  # without a definition, a class is taken by its name
        return made
    package, name = type_name.split("/")[::2]
    root = f"{package}/{name}"
    if not _same(_layout(definition(made), root), _layout(text, root), root):
        raise Unreadable(f"{type_name} has other fields here than in the file")
    return made


def _load(package: str, kind: str, name: str) -> Any:
    """The class of a message, or None."""
    made = message_classes.load(f"{package}/{kind}/{name}")
    if made is None and kind == "action" and name.endswith(_FEEDBACK):
        action = message_classes.load(f"{package}/{kind}/{name.removesuffix(_FEEDBACK)}")
        made = getattr(getattr(action, "Impl", None), "FeedbackMessage", None)
    return made if hasattr(made, "get_fields_and_field_types") else None


def _same(ours: _Layout, theirs: _Layout, root: str) -> bool:
    """True when both mean the same bytes. It follows what is installed here, which has an end."""
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


def _layout(text: str, root: str) -> _Layout:
    """The fields without what takes no bytes: constants, defaults, comments, bounds."""
    found: _Layout = {}
    for number, part in enumerate(_RULE.split(text)):
        name, body = root, part
        if number:
            head, _, body = part.lstrip().partition("\n")
            name = _complex(head.removeprefix("MSG:").strip(), root)
        found.setdefault(name, _fields(body, name))
    return found


def _fields(text: str, owner: str) -> list[_Field]:
    found = []
    for line in text.splitlines():
        field = _FIELD.match(line.strip())
        if field and field[5] != message_classes.EMPTY:
            kind = _NAMES.get(field[1], field[1])
            if kind not in _PRIMITIVES:
                kind = _complex(kind, owner)
            size = "" if field[3] else field[4] or ""
            found.append((kind, f"[{size}]" if field[2] else "", field[5]))
    return found


def _complex(name: str, owner: str) -> str:
    """`package/Name` of a message: without `/msg/`, and with the package of whose field it is."""
    first, *_, last = (name if "/" in name else f"{owner.split('/')[0]}/{name}").split("/")
    return f"{first}/{last}"
