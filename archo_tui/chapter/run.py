"""`archo-tui check`: hosts files of the user's own, and asks their nodes what the chapter asks.

It comes before the engine is chosen, and so imports no rclpy.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from archo_tui import engine
from archo_tui.errors import ArchoError
from archo_tui.hosting.node_output import NodeOutput
from archo_tui.session import Options, Session

_RADIUS = 0.07  # m, of the parameter file: not what the chapter's listing declares


def run(
    files: Sequence[str],
    engine_name: str,
    interfaces: Sequence[Path],
    say: Callable[[str], None],
) -> int:
    """Say every line of the outcome; returns the exit code.

    Raises ArchoError when a file cannot be hosted.
    """
    if engine_name == engine.ROS2:  # else real ROS 2 takes any value, and sends what it makes of it
        os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")
    with tempfile.TemporaryDirectory(prefix="archo-check-") as folder, _taken() as printed:
        values = Path(folder, "params.yaml")  # tell whether the nodes load a file at all
        values.write_text(f"/**:\n  ros__parameters:\n    wheel_radius: {_RADIUS}\n")
        given = Options(
            engine=engine_name,
            node_files=files,
            interfaces=interfaces,
            only=True,
            params_files=[values],
            domain_id=None,
        )
        with Session(given) as session:
            # not before the engine is chosen
            from archo_tui.chapter.check import check
            from archo_tui.hosting import host

            late = session.host.wait_longer(host.CONSTRUCTION_TIME)
            if late:
                raise ArchoError(late[0])
            return check(session, _RADIUS, printed, say)


@contextlib.contextmanager
def _taken() -> Iterator[list[str]]:
    """What nodes print is taken down, and not mixed with the outcome; they get no input."""
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
