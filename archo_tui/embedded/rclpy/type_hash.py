"""`rclpy.type_hash`: the hash of an interface's definition. None is computed here."""

from __future__ import annotations

from typing import TypedDict


class TypeHashDictionary(TypedDict):
    """A hash as a dictionary."""

    version: int
    value: bytes


class TypeHash:
    """A version of ROS's hashing (below 1: no hash) and 32 bytes."""

    _TYPE_HASH_SIZE = 32
    __slots__ = ("_value", "_version")

    def __init__(self, version: int = -1, value: bytes = bytes(_TYPE_HASH_SIZE)) -> None:
        """Raises AssertionError for values of another type."""
        self.version = version
        self.value = value

    @property
    def version(self) -> int:
        """Of the way of hashing."""
        return self._version

    @version.setter
    def version(self, value: int) -> None:
        is_number = isinstance(value, int)
        assert is_number
        self._version = value

    @property
    def value(self) -> bytes:
        """The hash itself."""
        return self._value

    @value.setter
    def value(self, value: bytes) -> None:
        is_bytes = isinstance(value, bytes)
        assert is_bytes
        self._value = value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TypeHash):
            return False
        return (self._version, self._value) == (other._version, other._value)

    __hash__ = None  # type: ignore[assignment]  # mutable, as rclpy's

    def __str__(self) -> str:
        if self._version <= 0 or len(self._value) != self._TYPE_HASH_SIZE:
            return "INVALID"
        return f"RIHS{self._version:02}_{self._value.hex()}"
