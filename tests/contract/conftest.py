"""Every test here states rclpy's behaviour and runs on each engine that is installed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.support.ros import Ros


@pytest.fixture
def ros() -> Iterator[Ros]:
    """A ROS graph of the test's own; callbacks must not have raised unless the test says so."""
    from tests.support.ros import Ros  # not before the engine is chosen

    graph = Ros()
    yield graph
    graph.close()
    assert graph.errors == []
