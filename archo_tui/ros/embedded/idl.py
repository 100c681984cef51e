"""A parser of ROS interface files (.msg, .srv, .action) that refuses what rosidl_adapter refuses.

The lines are `type name [default]`, `type NAME=constant` and `#` comments, with arrays `[]`,
`[N]`, `[<=N]` and bounded strings `string<=N`; `---` parts the sections.
"""

from __future__ import annotations

import keyword
import re
import warnings
from pathlib import Path
from typing import NamedTuple

_SHOWN = 40  # Characters of a wrong value that an error quotes.
_BOOLS = {"true": True, "1": True, "false": False, "0": False}
_ELEMENT = re.compile(  # An element of a list of texts, up to the comma.
    r""" *(?:"((?:[^"\\]|\\.)*)"|'((?:[^'\\]|\\.)*)'|([^,"' ][^,]*)) *,?"""
)
_PARTS = {".msg": 1, ".srv": 2, ".action": 3}
_PACKAGE = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")  # A field's name has the same form.
_CONSTANT = re.compile(r"[A-Z](_?[A-Z0-9])*")
_MESSAGE = re.compile(r"[A-Z][A-Za-z0-9]*")
_STRING = re.compile(r"(w?string)<=(.*)")
_ARRAY = re.compile(r"(.*)\[(<=)?([^\[]*)\]")
# Ends of the names of messages that services and actions are made of.
_SUFFIXES = ("_Request", "_Response", "_Goal", "_Result", "_Feedback")
# The lowest and the highest value of each integer type; `char` is uint8 in ROS 2.
INTEGERS = {
    f"{sign}int{bits}": (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
} | {"char": (0, 255)}
FLOATS = ("float32", "float64")
# Element types that rosidl keeps in array.array, with array's type codes.
TYPE_CODES = {
    "int8": "b", "uint8": "B", "char": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip
# The names in rosidl's `get_fields_and_field_types`.
_IDL_NAMES = {"bool": "boolean", "byte": "octet", "char": "uint8"} | {
    "float32": "float",
    "float64": "double",
}
PRIMITIVES = {*INTEGERS, *FLOATS, "bool", "byte", "string", "wstring"}
FLOAT32_MAX = 3.402823466e38


class FieldType(NamedTuple):
    """The type of a field in an interface file.

    `str()` of it is rosidl's notation, such as `sequence<double, 3>`.
    """

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


class InterfaceError(ImportError):
    """The error for an interface that cannot be used; its text starts with `file:line:`."""


class Field(NamedTuple):
    """A field: its type, name, default (None if the file gives none) and line number.

    The default is as `read_value` returns it: a byte is an int.
    """

    type: FieldType
    name: str
    default: object
    line: int


class Section(NamedTuple):
    """The fields and constants of one section of an interface file, in the file's order.

    `---` lines separate the sections. A constant is (name, type, value).
    """

    path: Path
    fields: list[Field]
    constants: list[tuple[str, FieldType, object]]


def is_package_name(name: str) -> bool:
    """Return True if `name` is a valid name of a ROS package."""
    return _PACKAGE.fullmatch(name) is not None


def parse(path: Path, package: str) -> list[Section]:
    """Parse an interface file."""
    if not _is_message(path.stem):
        raise InterfaceError(
            f"{path}:1: {path.stem} is not a name of an interface: capitals, letters and digits, "
            "like BatteryStatus"
        )
    return parse_text(_text(path), path, package, _PARTS[path.suffix])


def parse_text(text: str, path: Path, package: str, wanted: int) -> list[Section]:
    """Parse the wanted number of sections of an interface; errors name the path."""
    sections = [Section(path, [], [])]
    for number, line in enumerate(text.splitlines(), 1):
        if line == "---" and wanted > 1:
            sections.append(Section(path, [], []))
            continue
        try:
            _add(sections[-1], package, line.replace("\t", " "), number)
        except ValueError as error:
            raise InterfaceError(f"{path}:{number}: {error}") from None
    if len(sections) != wanted:
        raise InterfaceError(
            f"{path}:1: a {path.suffix} file has {wanted - 1} '---' lines, this one has "
            f"{len(sections) - 1}"
        )
    return sections


def _text(path: Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InterfaceError(f"{path}:{line}: not UTF-8: save it as that") from None


def _add(section: Section, package: str, line: str, number: int) -> None:
    """Add a line's field or constant to a section; ignore a blank line and a comment."""
    line = line.partition("#")[0].rstrip()  # within quotes, too
    if not line:
        return
    word, _, rest = line.partition(" ")
    rest = rest.lstrip()
    if not word:
        raise ValueError("begins with a space: 'type name' begins the line")
    if not rest:
        raise ValueError(f"not 'type name': {line!r}")
    if "=" in rest:
        name, _, text = rest.partition("=")
        constant = _constant(word, name.rstrip(), text.lstrip())
        if any(name == constant[0] for name, *_ in section.constants):
            raise ValueError(f"a second constant named {constant[0]!r}")
        section.constants.append(constant)
        return
    name, _, text = rest.partition(" ")
    field = _field(_type(word, package), name, text.lstrip(), number)
    if any(field.name == other.name for other in section.fields):
        raise ValueError(f"a second field named {name!r}")
    section.fields.append(field)


def _constant(word: str, name: str, text: str) -> tuple[str, FieldType, object]:
    if word not in PRIMITIVES:
        known = ", ".join(sorted(PRIMITIVES))
        raise ValueError(f"{word} is not a type of constants: one of {known}")
    if not _CONSTANT.fullmatch(name):
        raise ValueError(f"{name!r} is not a name of a constant: capitals, digits and single _")
    kind = FieldType(word)
    return name, kind, read_value(text, kind)


def _field(kind: FieldType, name: str, text: str, number: int) -> Field:
    if not _PACKAGE.fullmatch(name):
        raise ValueError(f"{name!r} is not a name of a field: small letters, digits and single _")
    if keyword.iskeyword(name):
        raise ValueError(f"{name!r} is a word of Python: rosidl's classes cannot be imported")
    default = read_value(text, kind) if text else None
    numbers = default if isinstance(default, list) else [default]
    for value in numbers if kind.base == "float32" else ():
        if isinstance(value, float) and FLOAT32_MAX < abs(value) < float("inf"):
            # As the setter of the message would.
            raise ValueError(f"{value:g} is too large for {kind.base}")
    return Field(kind, name, default, number)


def _type(word: str, package: str) -> FieldType:
    array = _ARRAY.fullmatch(word)
    if array is None:
        return _element(word, package)
    element, upto, size = _element(array[1], package), array[2], array[3]
    if not (upto or size):
        return element._replace(is_array=True)
    count = _count(size, f"the size of {word}")
    if upto:
        return element._replace(is_array=True, upper_bound=count)
    return element._replace(is_array=True, fixed_size=count)


def _element(word: str, package: str) -> FieldType:
    if word in PRIMITIVES:
        return FieldType(word)
    bounded = _STRING.fullmatch(word)
    if bounded is not None:
        return FieldType(bounded[1], string_bound=_count(bounded[2], f"the bound of {word}"))
    parts = word.split("/")
    before, name = parts if len(parts) == 2 else (package, word)
    if not (is_package_name(before) and _is_message(name)):
        raise ValueError(f"{word!r} is not a type: a primitive one, Name or package/Name")
    return FieldType(f"{before}/{name}")


def _count(text: str, what: str) -> int:
    try:
        count = int(text)
    except ValueError:
        count = 0
    if count <= 0:
        raise ValueError(f"{what} is a whole number above 0")
    return count


def _is_message(name: str) -> bool:
    name = name.removeprefix("Sample_")
    for suffix in _SUFFIXES:
        name = name.removesuffix(suffix)
    return _MESSAGE.fullmatch(name) is not None


def read_value(text: str, kind: FieldType) -> object:
    r"""Return the value of a constant or default as its text in an interface file means it.

    A byte is an int, an array a list. Escapes such as `\n` are decoded in a single text, but not
    in an array of texts.
    """
    if "/" in kind.base:
        raise ValueError(f"{kind.base} takes no default")
    if not kind.is_array:
        return _single(text, kind)
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError(f"expected a list like [1, 2], not {text[:_SHOWN]}")
    inside = text[1:-1]
    if kind.base in ("string", "wstring"):
        items = _texts(inside)  # Their escapes are not decoded.
    else:
        items = inside.split(",") if inside else []
    if kind.fixed_size is not None and len(items) != kind.fixed_size:
        raise ValueError(f"expected {kind.fixed_size} values, not {len(items)}")
    if kind.upper_bound is not None and len(items) > kind.upper_bound:
        raise ValueError(f"expected at most {kind.upper_bound} values, not {len(items)}")
    element = kind._replace(is_array=False, fixed_size=None, upper_bound=None)
    return [_single(item.strip(), element, is_element=True) for item in items]


def _single(text: str, kind: FieldType, *, is_element: bool = False) -> object:
    if kind.base in ("string", "wstring"):
        read = _unquoted(text, kind.string_bound)
        return _unescaped(read) if "\\" in read and not is_element else read
    if kind.base == "bool":
        if text.lower() not in _BOOLS:
            raise ValueError(f"expected true, false, 1 or 0, not {text[:_SHOWN]}")
        return _BOOLS[text.lower()]
    if kind.base in FLOATS:
        try:
            return float(text)
        except ValueError:
            raise ValueError(f"expected a number, not {text[:_SHOWN]}") from None
    low, high = INTEGERS.get(kind.base, (0, 255))  # The default is a byte's range.
    value = _whole(text)
    if value is None or not low <= value <= high:
        raise ValueError(f"expected a whole number within {low} .. {high}, not {text[:_SHOWN]}")
    return value


def _whole(text: str) -> int | None:
    for base in (10, 0):  # 010 is ten, 0x10 is sixteen.
        try:
            return int(text, base)
        except ValueError:
            continue
    return None


def _unquoted(text: str, bound: int | None) -> str:
    for quote in ('"', "'"):
        if text.startswith(quote) and text.endswith(quote):
            text = text[1:-1]
            if re.search(rf"(?<!\\){quote}", text):
                raise ValueError(f"a {quote} inside is written \\{quote}")
            text = text.replace(f"\\{quote}", quote)
            break
    if bound is not None and len(text) > bound:
        raise ValueError(f"expected at most {bound} characters, not {len(text)}")
    return text


def _unescaped(text: str) -> str:
    r"""Return a text with `\t` and the like decoded, as rosidl does by way of a Latin-1 file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # "\d" stays as written.
            plain = text.encode().decode("unicode_escape")
        return plain.encode("iso-8859-1").decode()
    except UnicodeError:
        raise ValueError(f"an escape that cannot be read: {text[:_SHOWN]}") from None


def _texts(inside: str) -> list[str]:
    found, place = [], 0
    while place < len(inside):
        item = _ELEMENT.match(inside, place)
        if item is None:
            raise ValueError(f"expected texts like 'a', \"b\", not {inside[place:][:_SHOWN]}")
        found.append(next(part for part in item.groups() if part is not None))
        place = item.end()
    return found
