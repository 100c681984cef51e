"""On ROS 2 a program is a process of its own, which must find the console."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _processes_find_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
