"""`--check` in real time: the listings, the robot's own nodes, and several files at once.

What single files are told is in `test_learners.py`.
"""

from __future__ import annotations

from pathlib import Path

import archo_bringup
import pytest

import tests.contract.textbook as textbook
from archo_tui.cli import main
from tests.support import chosen

LISTINGS = Path(textbook.__file__).parent
OURS = Path(archo_bringup.__file__).parent
pytestmark = pytest.mark.real_time


def check(capsys: pytest.CaptureFixture[str], *files: Path) -> tuple[int, list[str]]:
    """The exit code, and the lines that are not skipped."""
    words = [word for file in files for word in ("--check", str(file))]
    code = main(["--engine", chosen.ENGINE, *words])
    first, *lines, plan = capsys.readouterr().out.splitlines()
    assert (first, plan) == ("TAP version 13", "1..11")
    return code, [line for line in lines if "# SKIP" not in line]


def test_the_robots_own_nodes_pass(capsys: pytest.CaptureFixture[str]) -> None:
    names = ("battery_monitor", "dashboard", "motor_controller")
    code, lines = check(capsys, *(OURS / f"{name}.py" for name in names))
    assert code == 0, lines
    assert [line[:6].rstrip(" -") for line in lines] == [f"ok {n}" for n in range(1, 12)]


def test_a_listing_is_asked_for_what_it_offers_only(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, LISTINGS / "reset_service.py")
    assert code == 0
    assert [line[:6] for line in lines] == ["ok 9 -", "ok 11 "]


def test_a_crash_in_one_file_leaves_the_checks_of_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = (LISTINGS / "reset_service.py").read_text().replace("        return response\n", "")
    (tmp_path / "reset.py").write_text(broken)
    code, lines = check(capsys, tmp_path / "reset.py", LISTINGS / "battery_subscriber.py")
    assert code == 1
    assert "ok 4 - a level below 20 % is logged as a warning, and no other one" in lines
    hint = f"# {tmp_path}/reset.py:12: TypeError: reset_callback gives nothing back: end it with"
    assert sum(line.startswith(hint) for line in lines) == 2, lines
