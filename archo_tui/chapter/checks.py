"""All checks of the textbook's chapter, with their outcome in TAP (https://testanything.org).

TAP has a line for each check, `ok` or `not ok`, with hints below the latter. A check of something
that no node offers is skipped, and says what the nodes offer instead.
"""

from __future__ import annotations

from collections.abc import Sequence

from archo_tui.chapter.check_runner import CheckRunner
from archo_tui.chapter.move_checks import move_checks
from archo_tui.chapter.parameter_checks import parameter_checks
from archo_tui.chapter.service_checks import service_checks
from archo_tui.chapter.tap import Result, TapReport
from archo_tui.chapter.topic_checks import topic_checks
from archo_tui.session import Session

# STOP comes last, since it leaves the robot stopped.
_CHECKS = topic_checks, parameter_checks, move_checks, service_checks
_NOTHING_CHECKED = "nothing was checked: these nodes offer nothing that the chapter asks for"


def run_checks(session: Session, radius: float, printed: Sequence[str], report: TapReport) -> None:
    """Run every check of nodes, and report the outcomes; `TapReport.end` is left to the caller.

    Crashed nodes are restarted. Whether a node crashed is the last check. If nodes offer nothing to
    check, the report has failed, too.

    Args:
        session: The session that hosts the nodes.
        radius: The wheel_radius in m of the parameter file that all nodes were given.
        printed: The lines that the nodes print, which grow while they run.
        report: Gets the outcome of each check.

    Raises:
        KeyboardInterrupt: The person interrupted the checks, which the report says.
    """
    runner = CheckRunner(session, radius, printed)
    for line in runner.unrun_lines():
        report.comment(line)
    has_checked = False
    try:
        for checks in _CHECKS:
            for result in checks(runner):
                report.show(result)
                has_checked |= not result.skipped
        runner.wait_for_crashes()
        crashes = Result("no node crashes", "\n".join(runner.collect_crashes()))
        report.show(crashes)
    except KeyboardInterrupt:
        report.bail_out()
        raise
    finally:
        runner.close()
    if not has_checked:
        report.has_failed = True
        report.comment(_NOTHING_CHECKED)
