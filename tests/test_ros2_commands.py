"""docs/ros2_commands.md: each line of its table is typed, and does not fail."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.generated import ROOT
from tests.support.plain import operated
from tests.test_docs import codes, read

ROWS = list(read(ROOT / "docs" / "ros2_commands.md").rows)
LINES = [line for row in ROWS for line in codes(row["line"]) if not line.startswith("archo-tui ")]
NOT_ARCHOS = ("lifecycle bt_navigator activate",)  # tests/robots/test_field_page.py types it


def test_each_ros2_command_of_the_table_has_something_that_does_the_same() -> None:
    assert len(ROWS) >= 20
    for row in ROWS:
        (command,) = codes(row["with ros2"])
        assert command.startswith("ros2 ")
        assert row["on the screen"] or row["line"]


async def test_each_line_of_the_table_does_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    async with operated() as person:
        for line in LINES:
            if line not in NOT_ARCHOS:
                person.type(f"{line}\n")
                await person.is_read()
        code = await person.end()
    assert "failed:" not in person.said, person.said
    assert code == 0
    assert "archo_interfaces/msg/BatteryStatus" in person.said
    assert "max_speed 0.5" in person.said
    assert (tmp_path / "params.yaml").exists()
