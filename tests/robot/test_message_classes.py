"""A type's name comes from the graph or a file: nothing but interfaces is imported for it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from archo_tui.robot import message_classes


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
    assert message_classes.load(name) is None
    assert "evil" not in sys.modules


def test_interfaces_are_found_by_their_names() -> None:
    assert message_classes.load("std_msgs/msg/String").__name__ == "String"
    assert message_classes.load("archo_interfaces/action/MoveToShelf").__name__ == "MoveToShelf"
