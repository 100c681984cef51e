"""All checks of the textbook's chapter, with their outcome in TAP (https://testanything.org).

TAP has a line for each check, `ok` or `not ok`, with hints below the latter. A check of something
that no node offers is skipped, and says what the nodes offer instead.
"""

from __future__ import annotations

from archo_tui.user_code.check.check_runner import CheckRunner
from archo_tui.user_code.check.move_checks import move_checks
from archo_tui.user_code.check.parameter_checks import parameter_checks
from archo_tui.user_code.check.service_checks import service_checks
from archo_tui.user_code.check.tap import Result, TapReport
from archo_tui.user_code.check.topic_checks import topic_checks

# STOP comes last, since it leaves the robot stopped.
_CHECKS = topic_checks, parameter_checks, move_checks, service_checks
_NOTHING_CHECKED = "nothing was checked: these nodes offer nothing that the chapter asks for"


def run_checks(runner: CheckRunner, report: TapReport) -> None:
    """Run every check of the runner's programs, and report the outcomes but `TapReport.end`.

    Crashed programs are restarted. Whether one crashed is the last check. If there is nothing to
    check, the report has failed, too.
    """
    has_checked = False
    try:
        for checks in _CHECKS:
            for result in checks(runner):
                report.show(result)
        has_checked = report.has_checked
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
