"""What lies beside the messages in a recording: the robot file, the journal, the versions."""

from __future__ import annotations

import json
import sys
from datetime import datetime
from pathlib import Path

from archo_tui import __version__
from archo_tui.robot_file.dump import dump
from archo_tui.robot_file.model import RobotFile

_TAIL = 1_000_000  # bytes of the journal's end that are looked through


def attachments(robot: RobotFile, journal: Path, begin: float, end: float) -> dict[str, str]:
    """By name; of the journal the lines between two Unix times."""
    return {
        "robot.yaml": dump(robot),
        "journal.jsonl": "".join(_lines(journal, begin, end)),
        "versions.json": json.dumps({"archo-tui": __version__, "python": sys.version.split()[0]}),
    }


def _lines(journal: Path, begin: float, end: float) -> list[str]:
    try:
        with open(journal, "rb") as file:
            file.seek(max(journal.stat().st_size - _TAIL, 0))
            text = file.read(_TAIL).decode("utf-8", "replace")
    except OSError:
        return []
    return [line for line in text.splitlines(keepends=True) if begin <= _time(line) <= end]


def _time(line: str) -> float:
    try:
        return datetime.fromisoformat(json.loads(line)["time"]).timestamp()
    except (ValueError, KeyError, TypeError):  # cut off at its beginning
        return 0.0
