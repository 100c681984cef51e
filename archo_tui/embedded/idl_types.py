"""The types that a field of an interface file can have."""

from __future__ import annotations

from typing import NamedTuple

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
