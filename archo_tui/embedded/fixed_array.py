"""Arrays of numbers of a fixed size, as messages hold them: `uint8[16]`, `float64[36]`.

rosidl keeps them in `numpy.ndarray`. These arrays have what a message needs: elements are read,
set, compared and copied. For anything else make one a `numpy.array(...)`.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NoReturn

from .idl_types import TYPE_CODES

_AMBIGUOUS = (
    "The truth value of an array with more than one element is ambiguous. Use a.any() or a.all()"
)


def name_of(code: str) -> str:
    """Return the ROS type of a type code of array.array: `float64` for "d", `uint8` for "B"."""
    return next(name for name, of in TYPE_CODES.items() if of == code)


class Many:
    """The base of FixedArray and Truths: `all()`, `any()` and truth value, as in numpy.

    `bool()` raises ValueError unless there is exactly one element.
    """

    __slots__ = ()

    def __bool__(self: Any) -> bool:
        if len(self) != 1:
            raise ValueError(_AMBIGUOUS)
        return bool(self[0])

    def all(self: Any) -> bool:
        """Return True if no element is False or 0."""
        return all(iter(self))

    def any(self: Any) -> bool:
        """Return True if an element is neither False nor 0."""
        return any(iter(self))


class Truths(Many, tuple[bool, ...]):
    """The result of comparing two arrays: a tuple with one bool for each element."""

    __slots__ = ()

    def tolist(self) -> list[bool]:
        """Return the results as a list."""
        return list(self)


class FixedArray(Many):
    """An array of numbers whose length never changes, as messages hold `uint8[16]`.

    As in numpy, `==` and `!=` compare element by element and return Truths, and a single value is
    compared with every element, or assigned to every element of a slice. A wrong number of values
    raises ValueError.
    """

    __slots__ = ("_values",)
    __hash__ = None  # type: ignore[assignment]  # as numpy's

    def __init__(self, code: str, values: Iterable[Any]) -> None:
        self._values = array(code, values)

    def __len__(self) -> int:
        return len(self._values)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._values)

    def __getitem__(self, index: Any) -> Any:
        found = self._values[index]
        return Part(self._values.typecode, found) if isinstance(index, slice) else found

    def __setitem__(self, index: Any, value: Any) -> None:
        if not isinstance(index, slice):
            self._values[index] = value
            return
        places = range(len(self))[index]
        for place, one in zip(places, _broadcast(value, len(places)), strict=True):
            self._values[place] = one

    def __eq__(self, other: object) -> Truths:  # type: ignore[override]
        return Truths(a == b for a, b in zip(self, _broadcast(other, len(self)), strict=True))

    def __ne__(self, other: object) -> Truths:  # type: ignore[override]
        return Truths(not same for same in self == other)

    def copy(self) -> FixedArray:
        """Return another array with the same elements."""
        return FixedArray(self._values.typecode, self._values)

    def tolist(self) -> list[Any]:
        """Return the elements as a list."""
        return self._values.tolist()

    def tobytes(self) -> bytes:
        """Return the elements as bytes in this machine's byte order."""
        return self._values.tobytes()

    __bytes__ = tobytes

    @property
    def dtype(self) -> str:
        """Return the ROS name of the elements' type, such as `float64`."""
        return name_of(self._values.typecode)

    @property
    def size(self) -> int:
        """Return the number of elements."""
        return len(self._values)

    def __repr__(self) -> str:
        return f"array({self.tolist()}, dtype={self.dtype})"

    def __str__(self) -> str:
        return f"[{' '.join(map(str, self))}]"


class Part(FixedArray):
    """A slice of a FixedArray: a read-only copy, where numpy's is a view of the whole array.

    Assigning to an element raises TypeError.
    """

    __slots__ = ()

    def __setitem__(self, *_: Any) -> NoReturn:
        raise TypeError("a slice is a copy here and a view in numpy: assign to the whole array")


def _broadcast(value: Any, size: int) -> Sequence[Any]:
    """Return `size` values: `size` values as given, or a single one repeated.

    A single value may stand alone or in an iterable; a str and bytes are single values.

    Raises:
        ValueError: The number of values is neither 1 nor `size`.
    """
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        return [value] * size
    values = list(value)
    if len(values) not in (1, size):
        shapes = f"({size},) ({len(values)},)"
        raise ValueError(f"operands could not be broadcast together with shapes {shapes} ")
    return values if len(values) == size else values * size
