"""`archo-tui check`: runs the user's files and the chapter's checks on them.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from archo_tui.base.errors import ArchoError
from archo_tui.robot.state.snapshot import Life
from archo_tui.ros import engine
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from archo_tui.user_code.check.launch import check_launch_file, is_launch_file
from archo_tui.user_code.check.tap import Report
from archo_tui.user_code.output import NodeOutput

_RADIUS = 0.07  # In m; the chapter's listing declares another value.
# Seconds in which a program begins to spin; a process of ROS 2 takes its time.
_START_TIME = {engine.EMBEDDED: 8.0, engine.ROS2: 15.0}
_VALUES = f"/**: {{ros__parameters: {{max_speed: 0.8, wheel_radius: {_RADIUS}}}}}"


def run(
    files: Sequence[str],
    engine_name: str,
    interfaces: Sequence[Path],
    print_line: Callable[[str], None],
) -> int:
    """Check launch files, then run the other files and check their nodes; print each outcome."""
    report = Report(print_line)
    for file in filter(is_launch_file, files):
        check_launch_file(report, file)
    programs = [file for file in files if not is_launch_file(file)]
    if programs:
        _check_programs(programs, engine_name, interfaces, report)
    return report.end()


def _check_programs(
    files: Sequence[str], engine_name: str, interfaces: Sequence[Path], report: Report
) -> None:
    if engine_name == engine.ROS2:  # By default rclpy does not check the values of message fields.
        os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")
    with (
        tempfile.TemporaryDirectory(prefix="archo-check-") as folder,
        _captured_output() as printed,
    ):
        # The file shows if the nodes load parameters at all.
        values = Path(folder, "params.yaml")
        values.write_text(_VALUES)
        given = Options(
            engine=engine_name,
            node_files=files,
            interfaces=interfaces,
            only=True,
            params_files=[values],
            domain_id=None,
        )
        with Session(given) as session:
            # These import rclpy, so the engine must have been chosen.
            from archo_tui.user_code.check.chapter import check_programs
            from archo_tui.user_code.check.checker import Checker, wait_for_spins

            programs, clock = session.host.programs, session.station.clock
            wait_for_spins(programs, _START_TIME[engine_name])
            for program in programs:
                if program.state.life is Life.CRASHED and not program.has_spun:
                    raise ArchoError(program.crash)
                late = program.ask({"ask": "constructor"}).get("constructor", "")
                if late:
                    raise ArchoError(late)
            checker = Checker(session.host, session.context, clock, _RADIUS, printed)
            with contextlib.closing(checker):
                check_programs(report, checker)


@contextlib.contextmanager
def _captured_output() -> Iterator[list[str]]:
    """Capture the lines that other threads print, which nodes do, and give `input()` no text.

    The list grows while the context lasts; standard streams are restored at its end.
    """
    printed: list[str] = []

    def note(_level: str, _source: str, line: str) -> None:
        printed.append(line)

    before, sys.stdin = sys.stdin, io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(NodeOutput(sys.stdout or io.StringIO(), note)),
            contextlib.redirect_stderr(NodeOutput(sys.stderr or io.StringIO(), note)),
        ):
            yield printed
    finally:
        sys.stdin = before
