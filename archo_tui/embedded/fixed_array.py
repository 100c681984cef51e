"""Arrays of numbers of a fixed size, as messages hold them: `uint8[16]`, `float64[36]`.

rosidl keeps them in `numpy.ndarray`. These answer as those do where a node meets it: a comparison
gives a truth value an element, no `if` takes that, they do not grow, and methods that only
`array.array` has are not there. For arithmetic, views and dtypes make it a `numpy.array(...)`.
"""

from __future__ import annotations

import operator
from array import array
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NoReturn

from .idl_types import TYPE_CODES

_AMBIGUOUS = (
    "The truth value of an array with more than one element is ambiguous. Use a.any() or a.all()"
)
_code: Callable[[Any], str] = vars(array)["typecode"].__get__


def name_of(code: str) -> str:
    """The type that an array's type code stands for; uint8, not char, which is the same."""
    return next(name for name, of in TYPE_CODES.items() if of == code)


class Many:
    """What a comparison and an array have in common: no truth value, but those of the elements."""

    __slots__ = ()

    def __bool__(self: Any) -> bool:
        if len(self) != 1:
            raise ValueError(_AMBIGUOUS)
        return bool(self[0])

    def all(self: Any) -> bool:
        """True when every element is true, or not 0."""
        return all(iter(self))

    def any(self: Any) -> bool:
        """True when an element is true, or not 0."""
        return any(iter(self))


class Truths(Many, tuple[bool, ...]):
    """What a comparison gives: one an element."""

    __slots__ = ()

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


class FixedArray(Many, array):  # type: ignore[type-arg]  # of numbers of whatever type
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

    @property
    def dtype(self) -> str:
        """The name of the elements' type."""
        return name_of(_code(self))

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
