"""All checks of the textbook's chapter, with their outcome in TAP (https://testanything.org).

TAP has a line for each check, `ok` or `not ok`, with hints below the latter. A check of something
that no node offers is skipped, and says what the nodes offer instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from archo_tui.chapter.check_runner import CheckRunner
from archo_tui.chapter.move_checks import move_checks
from archo_tui.chapter.parameter_checks import parameter_checks
from archo_tui.chapter.service_checks import service_checks
from archo_tui.chapter.tap import Result
from archo_tui.chapter.topic_checks import topic_checks
from archo_tui.safe_text import safe
from archo_tui.session import Session

# STOP comes last, since it leaves the robot stopped.
_CHECKS = topic_checks, parameter_checks, move_checks, service_checks
_NOTHING_CHECKED = "# nothing was checked: these nodes offer nothing that the chapter asks for"


def run_checks(
    session: Session, radius: float, printed: Sequence[str], print_line: Callable[[str], None]
) -> int:
    """Run every check and print its outcome.

    Args:
        session: The session that hosts the nodes.
        radius: The wheel_radius in m of the parameter file that all nodes were given.
        printed: The lines that the nodes print, which grow while they run.
        print_line: Prints a line.

    Returns:
        The exit code: 0 if a check passed and none failed.
    """
    runner = CheckRunner(session, radius, printed)
    count = failed = skipped = 0

    def show(result: Result) -> None:
        nonlocal count, failed, skipped
        count, failed = count + 1, failed + bool(result.hint)
        skipped += bool(result.skipped)
        for line in result.lines(count):
            print_line(line)

    print_line("TAP version 13")
    for line in runner.unrun_lines():
        print_line(f"# {safe(line)}")
    try:
        for checks in _CHECKS:
            for result in checks(runner):
                show(result)
        nothing = skipped == count
        runner.wait_for_crashes()
        show(Result("no node crashes", "\n".join(runner.all_crashes())))
    except KeyboardInterrupt:
        print_line("Bail out! interrupted")
        raise
    finally:
        runner.close()
    if nothing:
        print_line(_NOTHING_CHECKED)
    print_line(f"1..{count}")
    return 1 if failed or nothing else 0
