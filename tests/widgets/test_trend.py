"""When the battery is empty or full, by how it goes at present."""

from __future__ import annotations

import pytest

from archo_tui.text.plot import time_left_text

Rates = list[tuple[float, float]]  # Pairs of % in a second, and seconds.


def samples(start: float, rates: Rates) -> tuple[tuple[float, float], ...]:
    """Return the charge of each second."""
    found = [(100.0, start)]
    for rate, seconds in rates:
        for _ in range(round(seconds)):
            at, charge = found[-1]
            found.append((at + 1.0, charge + rate))
    return tuple(found)


@pytest.mark.parametrize(
    ("start", "rates", "said"),
    [
        (22.5, [(-2.0, 10)], "empty in about 1 s"),
        (30.0, [(-2.0, 12)], "empty in about 3 s"),
        (60.0, [(-0.5, 40)], "empty in about 80 s"),
        (52.5, [(0.0, 25), (-2.0, 5)], "empty in about 20 s"),
        (60.0, [(-2.0, 20), (-0.05, 10)], ""),
        (60.0, [(-0.01, 30)], "empty in about 2 h"),
        (60.0, [(0.0, 30)], ""),
    ],
)
def test_the_time_left_goes_by_the_present_rate(start: float, rates: Rates, said: str) -> None:
    assert time_left_text(samples(start, rates), charging=False) == said


def test_the_time_to_a_full_battery_goes_by_the_present_rate_too() -> None:
    rates = [(0.5, 25.0), (2.0, 5.0)]
    assert time_left_text(samples(60.0, rates), charging=True) == "full in about 9 s"
