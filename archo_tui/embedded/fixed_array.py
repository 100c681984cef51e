"""Arrays of numbers of a fixed size, as messages hold them: `uint8[16]`, `float64[36]`.

rosidl keeps them in `numpy.ndarray`. These answer as those do where a node meets it: a comparison
gives a truth value an element, no `if` takes that, they do not grow, and what stands below only in
`array.array` is not there. Arithmetic, views and dtypes are numpy's own: use `numpy.array(...)`.
"""

from __future__ import annotations

import operator
from array import array
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NoReturn

NAMES = {
    "b": "int8", "B": "uint8", "h": "int16", "H": "uint16", "i": "int32", "I": "uint32",
    "q": "int64", "Q": "uint64", "f": "float32", "d": "float64",
}  # fmt: skip
_AMBIGUOUS = (
    "The truth value of an array with more than one element is ambiguous. Use a.any() or a.all()"
)
_code: Callable[[Any], str] = vars(array)["typecode"].__get__


class Truths(tuple[bool, ...]):
    """What a comparison gives: one an element."""

    __slots__ = ()

    def __bool__(self) -> bool:
        if len(self) != 1:
            raise ValueError(_AMBIGUOUS)
        return self[0]

    def all(self) -> bool:
        """True when every one is."""
        return all(iter(self))

    def any(self) -> bool:
        """True when one is."""
        return any(iter(self))

    def tolist(self) -> list[bool]:
        """As a list."""
        return list(self)


def _absent(name: str) -> property:
    def refuse(_: Any) -> NoReturn:
        raise AttributeError(f"'numpy.ndarray' object has no attribute {name!r}")

    return property(refuse)


def _arithmetic(*_: Any) -> NoReturn:
    raise TypeError("numpy's arithmetic is not emulated: make it a numpy.array(...) first")


def _comparison(compare: Callable[[Any, Any], bool]) -> Callable[[Any, Any], Truths]:
    def elementwise(self: FixedArray, other: Any) -> Truths:
        return Truths(compare(*pair) for pair in zip(self, _against(other, len(self)), strict=True))

    return elementwise


def _against(other: Any, size: int) -> Sequence[Any]:
    """What each element is compared with, or becomes."""
    if isinstance(other, (str, bytes)) or not isinstance(other, Iterable):
        return [other] * size
    values = list(other)
    if len(values) not in (1, size):
        shapes = f"({size},) ({len(values)},)"
        raise ValueError(f"operands could not be broadcast together with shapes {shapes} ")
    return values if len(values) == size else values * size


class FixedArray(array):  # type: ignore[type-arg]  # of numbers of whatever type
    """`FixedArray(typecode, values)`."""

    __slots__ = ()

    __eq__ = _comparison(operator.eq)  # type: ignore[assignment]
    __ne__ = _comparison(operator.ne)  # type: ignore[assignment]
    __lt__ = _comparison(operator.lt)  # type: ignore[assignment]
    __le__ = _comparison(operator.le)  # type: ignore[assignment]
    __gt__ = _comparison(operator.gt)  # type: ignore[assignment]
    __ge__ = _comparison(operator.ge)  # type: ignore[assignment]
    __add__ = __radd__ = __iadd__ = __mul__ = __rmul__ = __imul__ = _arithmetic

    append, extend, insert, pop, remove, clear, reverse, index, count = map(
        _absent,
        ("append", "extend", "insert", "pop", "remove", "clear", "reverse", "index", "count"),
    )
    typecode, buffer_info, fromlist, frombytes, fromfile, fromunicode, tounicode, byteswap = map(
        _absent,
        ("typecode", "buffer_info", "fromlist", "frombytes", "fromfile", "fromunicode",
         "tounicode", "byteswap"),
    )  # fmt: skip

    def __bool__(self) -> bool:
        if len(self) != 1:
            raise ValueError(_AMBIGUOUS)
        return bool(self[0])

    def __getitem__(self, index: Any) -> Any:
        found = super().__getitem__(index)
        return Part(_code(self), found) if isinstance(index, slice) else found

    def __setitem__(self, index: Any, value: Any) -> None:
        if not isinstance(index, slice):
            super().__setitem__(index, value)
            return
        places = range(*index.indices(len(self)))
        for place, one in zip(places, _against(value, len(places)), strict=True):
            super().__setitem__(place, one)

    def __delitem__(self, _: Any) -> NoReturn:
        raise ValueError("cannot delete array elements")

    def copy(self) -> FixedArray:
        """Another with the same elements."""
        return FixedArray(_code(self), self)

    __copy__ = copy

    def __deepcopy__(self, _: Any) -> FixedArray:
        return self.copy()

    def all(self) -> bool:
        """True when no element is 0."""
        return all(iter(self))

    def any(self) -> bool:
        """True when an element is not 0."""
        return any(iter(self))

    @property
    def dtype(self) -> str:
        """The name of the elements' type."""
        return NAMES[_code(self)]

    @property
    def size(self) -> int:
        """How many elements there are."""
        return len(self)

    @property
    def shape(self) -> tuple[int]:
        """Its only dimension."""
        return (len(self),)

    def __repr__(self) -> str:
        return f"array({self.tolist()}, dtype={self.dtype})"

    def __str__(self) -> str:
        return f"[{' '.join(map(str, self))}]"


class Part(FixedArray):
    """A slice. numpy's is a view of the whole, this one a copy: it takes no values."""

    __slots__ = ()

    def __setitem__(self, *_: Any) -> NoReturn:
        raise TypeError("a slice is a copy here and a view in numpy: assign to the whole array")
