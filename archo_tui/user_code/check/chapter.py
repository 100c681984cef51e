"""All checks of programs, a row each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from archo_tui.user_code.check import motion, motor, topics
from archo_tui.user_code.check.checker import Checker
from archo_tui.user_code.check.tap import Failed, Report

_PRINT_TIME = 0.5  # Seconds in which a line that a process prints comes.
_Check = Callable[[Checker], str | None]
_CHECKS: dict[str, _Check] = {
    "battery_level is a std_msgs/msg/Float32": topics.check_type,
    "battery_level is published about once a second": topics.check_rate,
    "the battery level never rises, and is within 0 .. 100": topics.check_levels,
    "a level below 20 % is logged as a warning, any other is not": topics.check_warning,
    "the parameters max_speed and wheel_radius are declared": motor.check_declared,
    "parameters are loaded from a YAML file": motor.check_loaded,
    "move_to_shelf gives feedback 15, 12 ... 0 and arrives": motion.check_arrival,
    "a cancel at 9 m ends the move as CANCELED": motion.check_cancel,
    "reset_encoder sets the encoder to zero, and answers True, 'Encoder reset to zero'": (
        motor.check_reset
    ),
    "emergency_stop answers True": motor.check_stop,  # It leaves the robot stopped.
}


def check_programs(report: Report, checker: Checker) -> None:
    """Check the checker's programs; those that crash are run again."""
    for title, check in _CHECKS.items():
        report.check(title, partial(_with_exception, check, checker))
    has_checked = report.has_checked
    report.check("no node crashes", checker.check_crashes)
    if not has_checked:
        report.fail("nothing was checked: these nodes offer nothing that the chapter asks for")


def _with_exception(check: _Check, checker: Checker) -> str | None:
    """Run a check; if it fails, an exception that the programs print meanwhile is the reason."""
    since = len(checker.printed)
    try:
        return check(checker)
    except Failed as error:
        checker.until(partial(checker.last_exception, since), _PRINT_TIME)
        raise Failed(checker.last_exception(since) or str(error)) from None
