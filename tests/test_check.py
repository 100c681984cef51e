"""`--check`: the chapter's questions, asked of the listings and of the robot's own nodes."""

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
    assert (first, plan) == ("TAP version 13", "1..9")
    return code, [line for line in lines if "# SKIP" not in line]


def test_the_robots_own_nodes_pass(capsys: pytest.CaptureFixture[str]) -> None:
    names = ("battery_monitor", "dashboard", "motor_controller")
    code, lines = check(capsys, *(OURS / f"{name}.py" for name in names))
    assert code == 0, lines
    assert [line[:5] for line in lines] == [f"ok {number} " for number in range(1, 10)]


def test_a_listing_is_asked_for_what_it_offers_only(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, LISTINGS / "reset_service.py")
    assert code == 0
    assert lines == ["ok 8 - reset_encoder answers True, 'Encoder reset to zero'"]


def test_a_move_that_sleeps_takes_no_cancel(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, LISTINGS / "move_action_server.py")
    assert code == 1
    assert lines[0] == "ok 6 - move_to_shelf gives feedback 15, 12 ... 0 and arrives"
    assert lines[1] == "not ok 7 - a cancel at 9 m ends the move as CANCELED"
    assert "while execute sleeps, a single-threaded executor takes no cancel" in lines[2]


def test_a_battery_in_a_hurry_is_told_its_period(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, LISTINGS / "battery_publisher.py")
    assert code == 1
    assert lines[0].startswith("not ok 1 ")
    assert "one every 0.0" in lines[1]
    assert lines[2].startswith("ok 2 ")


def test_a_wrong_answer_and_a_silent_dashboard_are_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reset = (LISTINGS / "reset_service.py").read_text().replace("Encoder reset to zero", "Done")
    (tmp_path / "reset.py").write_text(reset)
    listing = (LISTINGS / "battery_subscriber.py").read_text()
    (tmp_path / "dashboard.py").write_text(listing.replace("< 20.0", "< -20.0"))
    code, lines = check(capsys, tmp_path / "reset.py", tmp_path / "dashboard.py")
    assert code == 1
    assert "# answered True, 'Done'" in lines
    assert any("nothing logged" in line for line in lines)


def test_a_file_that_cannot_run_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "broken.py"
    file.write_text("def x(:\n")
    assert main(["--engine", chosen.ENGINE, "--check", str(file)]) == 2
    assert "broken.py:1: SyntaxError: " in capsys.readouterr().err
