"""A type's name comes from the graph or a file: nothing but interfaces is imported for it."""

from __future__ import annotations

import importlib
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from archo_tui.robot.messages.types import load_class
from archo_tui.session.session import _robots_nodes
from tests.support.quiet import ended, until
from tests.support.robot import robot


@pytest.mark.parametrize(
    "name", ["evil/msg/X", "evil.inner/msg/X", "evil/inner/X", "../msg/X", "", "/msg/X", "a/b/c/d"]
)
def test_a_module_that_is_no_package_of_interfaces_is_not_imported(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "evil").mkdir()
    for file in ("__init__.py", "inner.py"):
        (tmp_path / "evil" / file).write_text("raise SystemExit('imported')\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert load_class(name) is None
    assert "evil" not in sys.modules


def test_interfaces_are_found_by_their_names() -> None:
    assert load_class("std_msgs/msg/String").__name__ == "String"
    assert load_class("archo_interfaces/action/MoveToShelf").__name__ == "MoveToShelf"


async def test_a_class_of_the_robot_file_is_loaded_before_the_ros_thread_needs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a slow disk the first import takes long, and a STOP would wait for it."""
    loaded: list[tuple[str, str]] = []
    load = importlib.import_module

    def noted(name: str, package: str | None = None) -> Any:
        if package is None:  # rclpy's own imports are relative ones.
            loaded.append((threading.current_thread().name, name))
        return load(name, package)

    monkeypatch.setattr(importlib, "import_module", noted)
    async with robot(*_robots_nodes(False).values()) as it:
        await until(lambda: it.snapshot.battery.percentage is not None)
        assert (await ended(it.emergency_stop())).ok
    on_ros_thread = {module for thread, module in loaded if thread == "archo-client"}
    before = {module for thread, module in loaded if thread == threading.main_thread().name}
    assert on_ros_thread
    assert on_ros_thread <= before
