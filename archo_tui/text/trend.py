"""The charge over the last minutes, and when the battery will be empty. Pure functions."""

from __future__ import annotations

from archo_tui.text.state import BARS

Samples = tuple[tuple[float, float], ...]  # Pairs of monotonic s and %, oldest first.

_BAR_SECONDS = 5.0
_MIN_SPAN = 5.0  # In %, from the lowest to the highest bar, so that noise looks like noise.
_WINDOW = 30.0  # Seconds of samples for the estimate.
_PRESENT = 5.0  # Seconds of samples that tell how it goes at present,
_MUCH = 2.0  # if in the window before the charge changed by so many %,
_LEAST_SHARE = 2 / 3  # and whose rate is no other one by chance if it differs by more.
_MIN_SAMPLED = 3.0  # Seconds of samples below which there is no estimate.


def sparkline(samples: Samples, width: int) -> str:
    """Return a bar for each 5 s that have samples, the newest at the right end, and the range."""
    cells: dict[int, float] = {}
    for at, percentage in samples:
        cells[int(at // _BAR_SECONDS)] = percentage
    shown = [cells[cell] for cell in sorted(cells)][-(width - len(" 100 .. 100 %")) :]
    if not shown:
        return ""
    low, high = min(shown), max(shown)
    span = max(high - low, _MIN_SPAN)
    bars = "".join(BARS[int((value - low) / span * (len(BARS) - 1))] for value in shown)
    return f"{bars} {low:.0f} .. {high:.0f} %".rjust(width)


def time_left_text(samples: Samples, *, charging: bool) -> str:
    """Return `empty in about 2 min`, or `full ...`, by the trend of the last 30 s."""
    seconds = _seconds_to_end(samples, charging)
    if seconds is None:
        return ""
    return f"{'full' if charging else 'empty'} in about {_round_duration(seconds)}"


def _seconds_to_end(samples: Samples, charging: bool) -> float | None:
    if not samples:
        return None
    last_at, last = samples[-1]
    at, percentage = next(sample for sample in samples if last_at - sample[0] <= _WINDOW)
    way = 1.0 if charging else -1.0
    gained = way * (last - percentage)
    if last_at - at < _MIN_SAMPLED or gained <= 0:
        return None
    rate = gained / (last_at - at)
    at, percentage = next(sample for sample in samples if last_at - sample[0] <= _PRESENT)
    if gained >= _MUCH and last_at > at:  # Enough to see whether it goes on like that.
        lately = way * (last - percentage)
        present = lately / (last_at - at)
        if not _LEAST_SHARE <= present / rate <= 1 / _LEAST_SHARE:
            if lately < _MUCH / 2:
                return None
            rate = present
    return (100.0 - last if charging else last) / rate


def _round_duration(seconds: float) -> str:
    """Return a duration in one or two digits: `4 s`, `40 s`, `12 min`, `3 h`; `days` from 100 h."""
    if seconds < 100:
        return f"{max(round(seconds, -1 if seconds >= 10 else 0), 1):.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.0f} h" if seconds < 360_000 else "days"
