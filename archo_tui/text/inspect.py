"""The texts of one topic that somebody looks at. Pure functions."""

from __future__ import annotations

from typing import Any, Protocol


class Counted(Protocol):
    """The statistics of counted messages: see `Inspection`."""

    count: int
    size: int  # Bytes of all.
    kept: int  # Messages that were sent before.
    kept_size: int  # Bytes of these.
    least: float | None  # Between two messages, in s; None with fewer than two.
    greatest: float | None

    @property
    def rate(self) -> float | None:
        """Return the messages in a second; None if that is not known."""


def rate_text(
    counted: Counted, seconds: float, known_rate: float | None
) -> tuple[str, dict[str, Any]]:
    """Return how often messages came and their size: a text, and the same as JSON values."""
    count = counted.count - counted.kept
    bytes_per_second = (counted.size - counted.kept_size) / seconds
    rate = known_rate if counted.rate is None else counted.rate
    data: dict[str, Any] = {
        "messages": count,
        "rate": rate,
        "least": counted.least,
        "greatest": counted.greatest,
        "bytes_per_second": bytes_per_second,
    }
    sizes = f"{size_text(bytes_per_second)}/s"
    if not count:
        return f"no message in {seconds:g} s, but the last one that was sent before", data
    hertz = "--" if rate is None else f"{rate:.1f}"
    if counted.least is None or counted.greatest is None:
        return f"{hertz} Hz, 1 message in {seconds:g} s, {sizes}", data
    between = f"{counted.least:.3f} .. {counted.greatest:.3f} s between them"
    return f"{hertz} Hz, {count} messages in {seconds:g} s, {between}, {sizes}", data


def size_text(size: float) -> str:
    """Return a number of bytes in B, kB or MB, each 1000 times the one before: `1.4 kB`."""
    if size < 1000:
        return f"{size:.0f} B"
    return f"{size / 1e3:.1f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"
