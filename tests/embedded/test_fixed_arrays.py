"""What arrays of a fixed size lack here is refused, where numpy's would do something else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from archo_tui.embedded.fixed_array import FixedArray


@pytest.mark.parametrize(
    "use",
    [
        lambda one: one + 1,
        lambda one: one.__radd__([1]),
        lambda one: one * 2,
        lambda one: 2 * one,
        lambda one: one + one,
        lambda one: one - one,
        lambda one: -one,
        lambda one: one.__iadd__(one),
        lambda one: one.__imul__(2),
    ],
)
def test_arithmetic_is_refused(use: Callable[[Any], object]) -> None:
    one = FixedArray("B", [7] * 16)
    with pytest.raises(TypeError):
        use(one)
    assert one.tolist() == [7] * 16


def test_a_slice_takes_no_values_as_they_would_not_reach_the_whole() -> None:
    one = FixedArray("B", [7] * 16)
    for index in (0, slice(0, 2)):
        with pytest.raises(TypeError, match="assign to the whole array"):
            one[2:5][index] = 1
