"""What arrays of a fixed size lack here is refused, where numpy's would do something else."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import pytest

from archo_tui.embedded.fixed_array import FixedArray


@pytest.mark.parametrize(
    "use",
    [
        lambda one: one + 1,
        lambda one: operator.add([1], one),
        lambda one: one * 2,
        lambda one: 2 * one,
        lambda one: one + one,
        lambda one: one - one,
        lambda one: -one,
        lambda one: one < one,
    ],
)
def test_arithmetic_and_order_are_refused(use: Callable[[Any], object]) -> None:
    one = FixedArray("B", [7] * 16)
    with pytest.raises(TypeError):
        use(one)
    assert one.tolist() == [7] * 16


def test_a_slice_takes_no_values_as_they_would_not_reach_the_whole() -> None:
    one = FixedArray("B", [7] * 16)
    for index in (0, slice(0, 2)):
        with pytest.raises(TypeError, match="assign to the whole array"):
            one[2:5][index] = 1
