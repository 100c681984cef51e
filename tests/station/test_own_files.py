"""The console's own files: whatever lies in their place, it starts, and ends when it is told to."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from archo_tui.base import regular_files
from archo_tui.base.paths import config_file, state_file
from archo_tui.screen.terminal import themes
from archo_tui.screen.terminal.stderr import guarded_streams


def _large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1_000_000_000)


def _without_end(path: Path) -> None:
    path.symlink_to("/dev/zero")


@pytest.fixture(params=[os.mkfifo, _large, _without_end, Path.mkdir])
def misplaced(request: pytest.FixtureRequest) -> Callable[[Path], Path]:
    """Puts something else where a file of ours would be."""

    def put(path: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        request.param(path)
        return path

    return put


def test_no_theme_is_remembered(misplaced: Callable[[Path], Path]) -> None:
    misplaced(config_file("theme"))
    assert themes.remembered_theme() == ""


def test_what_libraries_print_leads_somewhere(misplaced: Callable[[Path], Path]) -> None:
    with guarded_streams(misplaced(state_file("stderr.log"))):
        os.write(2, b"said by a library\n")


def test_what_a_screen_left_stays_for_a_report_up_to_a_megabyte(tmp_path: Path) -> None:
    log = tmp_path / "stderr.log"
    for number, expected in ((1, "1"), (2, "12")):
        with guarded_streams(log):
            os.write(2, b"%d" % number)
        assert log.read_text() == expected
    log.write_bytes(b" " * 1_000_001)
    with guarded_streams(log):
        os.write(2, b"3")
    assert log.read_text() == "3"


def test_a_full_disk_leaves_nothing_half_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write_half(path: Path, *_: object, **__: object) -> int:
        path.touch()
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", write_half)
    with pytest.raises(OSError, match="No space"):
        regular_files.replace(tmp_path / "theme", "text")
    assert list(tmp_path.iterdir()) == []
