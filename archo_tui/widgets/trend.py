"""How the charge went, and when it will be empty or full. Pure: samples in, text out."""

from __future__ import annotations

Samples = tuple[tuple[float, float], ...]  # (monotonic s, %), oldest first

_BARS = "▁▂▃▄▅▆▇█"
_CELL = 5.0  # s that one bar stands for
_LEAST_SPAN = 5.0  # % from the lowest to the highest bar, so that noise looks like noise
_WINDOW = 30.0  # s that the estimate looks back
_ENOUGH = 3.0  # s of samples without which there is no estimate


def sparkline(samples: Samples, width: int) -> str:
    """One bar for every 5 s, the newest at the right end, and between what they lie.

    `     ▇▇▆▅▅▄ 18 .. 24 %` in `width` cells, with as many bars as there is room for.
    """
    cells: dict[int, float] = {}
    for at, percentage in samples:
        cells[int(at // _CELL)] = percentage
    shown = [cells[cell] for cell in sorted(cells)][-(width - len(" 100 .. 100 %")) :]
    if not shown:
        return ""
    low, high = min(shown), max(shown)
    span = max(high - low, _LEAST_SPAN)
    bars = "".join(_BARS[int((value - low) / span * (len(_BARS) - 1))] for value in shown)
    return f"{bars} {low:.0f} .. {high:.0f} %".rjust(width)


def end_text(samples: Samples, *, charging: bool) -> str:
    """`empty in about 2 min`, or an empty string when that cannot be told."""
    seconds = _seconds_to_end(samples, charging)
    if seconds is None:
        return ""
    return f"{'full' if charging else 'empty'} in about {_rough(seconds)}"


def _seconds_to_end(samples: Samples, charging: bool) -> float | None:
    if not samples:
        return None
    last_at, last = samples[-1]
    at, percentage = next(sample for sample in samples if last_at - sample[0] <= _WINDOW)
    gained = last - percentage if charging else percentage - last
    if last_at - at < _ENOUGH or gained <= 0:
        return None
    left = 100.0 - last if charging else last
    return left * (last_at - at) / gained


def _rough(seconds: float) -> str:
    """An estimate, no finer than it is good."""
    if seconds < 100:
        return f"{max(round(seconds, -1), 10):.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.0f} h" if seconds < 360_000 else "days"
