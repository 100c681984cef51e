"""Marks the contracts that the ROS 2 of this environment does not keep."""

from __future__ import annotations

import pytest

from archo_tui.ros import release as ros_release
from tests.contract.releases import DIFFERENCES
from tests.support import chosen


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if chosen.ENGINE != "ros2":
        return
    differences = {one.test: one for one in DIFFERENCES.get(ros_release.distribution(), [])}
    for item in items:
        difference = differences.get(getattr(item, "originalname", ""))
        if "contract" in item.path.parts and difference:
            mark = pytest.mark.xfail(reason=difference.there, run=not difference.hangs, strict=True)
            item.add_marker(mark)
