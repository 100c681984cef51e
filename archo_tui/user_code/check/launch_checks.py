"""The checks of a launch file, which is evaluated and not run.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from archo_tui.errors import ArchoError
from archo_tui.launch.evaluate import evaluate
from archo_tui.launch.plan import LaunchedProgram, LaunchPlan
from archo_tui.launch.workspace import Workspace
from archo_tui.nearest import nearest_hint
from archo_tui.user_code.check.tap import Result

_NODES = ("battery_monitor", "dashboard", "motor_controller")
_DRAIN = "fake_battery_drain"
_READ = "the launch file can be evaluated"
_THREE = f"it starts {', '.join(_NODES[:-1])} and {_NODES[-1]}"
_LOADED = "motor_controller gets its parameters"
_DEFAULT = f"use_sim is false by default, and starts no {_DRAIN}"
_SIMULATED = f"use_sim:=true starts {_DRAIN}"
_ENDINGS = (".launch.py", "_launch.py")  # As the names of launch files end.


def is_launch_file(given: str) -> bool:
    """Return True if a name ends as that of a launch file in Python; the file is not looked at."""
    return given.endswith(_ENDINGS)


def launch_checks(given: str) -> Iterator[Result]:
    """Yield the outcome of each of the five checks of a launch file.

    The file is evaluated in a child process, and again with `use_sim:=true` if it declares that;
    nothing is started. If it cannot be evaluated, the first check fails and the others are skipped.
    """
    try:
        plan = _evaluate(given, {})
    except ArchoError as error:
        yield Result(_READ, str(error))
        for name in (_THREE, _LOADED, _DEFAULT, _SIMULATED):
            yield Result(name, skipped="the launch file cannot be evaluated")
        return
    yield Result(_READ)
    programs = _by_name(plan)
    yield Result(_THREE, "\n".join(_missing_node_lines(plan, programs)))
    yield _parameter_file_result(programs)
    yield Result(_DEFAULT, _default_hint(plan, programs))
    yield _simulation_result(given, plan)


def _evaluate(given: str, arguments: Mapping[str, str]) -> LaunchPlan:
    with tempfile.TemporaryDirectory(prefix="archo-check-") as prefix:
        return evaluate(given, Workspace.around(Path(given)), Path(prefix), arguments)


def _by_name(plan: LaunchPlan) -> dict[str, LaunchedProgram]:
    """Return the programs by their nodes' names, else their executables; of several the last."""
    return {program.name or program.executable: program for program in plan.programs}


def _missing_node_lines(plan: LaunchPlan, programs: Mapping[str, LaunchedProgram]) -> Iterator[str]:
    missing = [name for name in _NODES if name not in programs]
    others = [name for name in programs if name not in _NODES]
    for name in missing:
        yield f"not started: {name}{nearest_hint(name, others)}: Node(package=..., executable=...)"
    if missing:
        yield from (str(note) for note in plan.notes if note.level == "WARN")


def _parameter_file_result(programs: Mapping[str, LaunchedProgram]) -> Result:
    motor = programs.get("motor_controller")
    if motor is None:
        return Result(_LOADED, skipped="it starts no motor_controller")
    if {"--params-file", "-p"} & {*motor.ros_args}:
        return Result(_LOADED)
    where = f"{Path(motor.file).name}:{motor.line}"
    how = "parameters=[os.path.join(get_package_share_directory(...), 'config', '....yaml')]"
    return Result(_LOADED, f"{where}: no parameters for it: {how}")


def _default_hint(plan: LaunchPlan, programs: Mapping[str, LaunchedProgram]) -> str:
    use_sim = next((a for a in plan.arguments if a.name == "use_sim"), None)
    if use_sim is None:
        near = nearest_hint("use_sim", [argument.name for argument in plan.arguments])
        return f"not declared: use_sim{near}: DeclareLaunchArgument('use_sim', default_value=...)"
    if (use_sim.default or "").lower() not in ("false", "0"):
        default = "no default" if use_sim.default is None else f"the default {use_sim.default!r}"
        return f"use_sim has {default}: default_value='false'"
    if _DRAIN in programs:
        how = "condition=IfCondition(LaunchConfiguration('use_sim'))"
        return f"{_DRAIN} is started without use_sim: {how}"
    return ""


def _simulation_result(given: str, plan: LaunchPlan) -> Result:
    if not any(argument.name == "use_sim" for argument in plan.arguments):
        return Result(_SIMULATED, skipped="use_sim is not declared")
    try:
        simulated = _evaluate(given, {"use_sim": "true"})
    except ArchoError as error:
        return Result(_SIMULATED, str(error))
    if _DRAIN in _by_name(simulated):
        return Result(_SIMULATED)
    notes = [str(note) for note in simulated.notes if note.level == "WARN"]
    return Result(_SIMULATED, "\n".join([f"not started: {_DRAIN}", *notes]))
