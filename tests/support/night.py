"""Combinations of which each run takes the corners, and the night takes all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def corners(always: Sequence[Any], by_night: Sequence[Any]) -> list[Any]:
    """Return values for `pytest.mark.parametrize`, of which the last ones are run by night only."""
    return [*always, *(_param(value) for value in by_night)]


def _param(value: Any) -> Any:
    values = value if isinstance(value, tuple) and not isinstance(value[0], int) else (value,)
    return pytest.param(*values, marks=pytest.mark.night)
