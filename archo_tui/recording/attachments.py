"""The attachments of a recording: the robot file, the journal and the versions."""

from __future__ import annotations

import json
import sys
from datetime import datetime
from pathlib import Path

from archo_tui import __version__
from archo_tui.robot_file.dump import dump
from archo_tui.robot_file.model import RobotFile

_MAX_JOURNAL_BYTES = 1_000_000  # Read from the end of the journal.


def attachments(robot: RobotFile, journal: Path, begin: float, end: float) -> dict[str, str]:
    """Return the text of each attachment by its file name: robot file, journal and versions.

    It reads at most the last megabyte of the journal.

    Args:
        robot: The robot, written as a robot file.
        journal: The journal's file; one that is missing or cannot be read counts as empty.
        begin: Unix time of the first journal line that is included.
        end: Unix time of the last one.
    """
    return {
        "robot.yaml": dump(robot),
        "journal.jsonl": "".join(_journal_lines(journal, begin, end)),
        "versions.json": json.dumps({"archo-tui": __version__, "python": sys.version.split()[0]}),
    }


def _journal_lines(journal: Path, begin: float, end: float) -> list[str]:
    try:
        with open(journal, "rb") as file:
            file.seek(max(journal.stat().st_size - _MAX_JOURNAL_BYTES, 0))
            text = file.read(_MAX_JOURNAL_BYTES).decode("utf-8", "replace")
    except OSError:
        return []
    return [line for line in text.splitlines(keepends=True) if begin <= _line_time(line) <= end]


def _line_time(line: str) -> float:
    try:
        return datetime.fromisoformat(json.loads(line)["time"]).timestamp()
    except (ValueError, KeyError, TypeError):  # The first line read may lack its beginning.
        return 0.0
