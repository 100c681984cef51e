"""The checks of a launch file, which is evaluated and not run.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest_hint
from archo_tui.user_code.check.tap import Failed, Report, Skipped
from archo_tui.user_code.ros_launch.evaluate import evaluate
from archo_tui.user_code.ros_launch.plan import LaunchedProgram, LaunchPlan
from archo_tui.user_code.ros_launch.workspace import Workspace

_NODES = ("battery_monitor", "dashboard", "motor_controller")
_DRAIN = "fake_battery_drain"


def is_launch_file(given: str) -> bool:
    """Return True if a name ends as that of a launch file in Python; the file is not looked at."""
    return given.endswith((".launch.py", "_launch.py"))


def check_launch_file(report: Report, given: str) -> None:
    """Check a launch file: evaluate it, and again with `use_sim:=true` if it declares that."""
    plans: list[LaunchPlan] = []
    report.check("the launch file can be evaluated", lambda: plans.append(_evaluate(given, {})))
    for title, check in (
        (f"it starts {', '.join(_NODES[:-1])} and {_NODES[-1]}", _check_nodes),
        ("motor_controller gets its parameters", _check_parameters),
        (f"use_sim is false by default, and starts no {_DRAIN}", _check_default),
        (f"use_sim:=true starts {_DRAIN}", partial(_check_simulation, given)),
    ):
        report.check(title, partial(check, *plans) if plans else _skip)


def _skip() -> None:
    raise Skipped("the launch file cannot be evaluated")


def _evaluate(given: str, arguments: Mapping[str, str]) -> LaunchPlan:
    try:
        with tempfile.TemporaryDirectory(prefix="archo-check-") as prefix:
            return evaluate(given, Workspace.around(Path(given)), Path(prefix), arguments)
    except ArchoError as error:
        raise Failed(str(error)) from None


def _by_name(plan: LaunchPlan) -> dict[str, LaunchedProgram]:
    """Return the programs by their nodes' names, else their executables; of several the last."""
    return {program.name or program.executable: program for program in plan.programs}


def _warnings(plan: LaunchPlan) -> list[str]:
    return [str(note) for note in plan.notes if note.level == "WARN"]


def _check_nodes(plan: LaunchPlan) -> None:
    found = _by_name(plan)
    others = [name for name in found if name not in _NODES]
    missing = [
        f"not started: {name}{nearest_hint(name, others)}: Node(package=..., executable=...)"
        for name in _NODES
        if name not in found
    ]
    if missing:
        raise Failed("\n".join(missing + _warnings(plan)))


def _check_parameters(plan: LaunchPlan) -> None:
    motor = _by_name(plan).get("motor_controller")
    if motor is None:
        raise Skipped("it starts no motor_controller")
    if {"--params-file", "-p"}.isdisjoint(motor.ros_args):
        where = f"{Path(motor.file).name}:{motor.line}"
        how = "parameters=[os.path.join(get_package_share_directory(...), 'config', '....yaml')]"
        raise Failed(f"{where}: no parameters for it: {how}")


def _check_default(plan: LaunchPlan) -> None:
    use_sim = next((a for a in plan.arguments if a.name == "use_sim"), None)
    if use_sim is None:
        near = nearest_hint("use_sim", [argument.name for argument in plan.arguments])
        how = "DeclareLaunchArgument('use_sim', default_value=...)"
        raise Failed(f"not declared: use_sim{near}: {how}")
    if (use_sim.default or "").lower() not in ("false", "0"):
        default = "no default" if use_sim.default is None else f"the default {use_sim.default!r}"
        raise Failed(f"use_sim has {default}: default_value='false'")
    if _DRAIN in _by_name(plan):
        how = "condition=IfCondition(LaunchConfiguration('use_sim'))"
        raise Failed(f"{_DRAIN} is started without use_sim: {how}")


def _check_simulation(given: str, plan: LaunchPlan) -> None:
    """Check that `use_sim:=true` starts the drain of the battery."""
    if not any(argument.name == "use_sim" for argument in plan.arguments):
        raise Skipped("use_sim is not declared")
    simulated = _evaluate(given, {"use_sim": "true"})
    if _DRAIN not in _by_name(simulated):
        raise Failed("\n".join([f"not started: {_DRAIN}", *_warnings(simulated)]))
