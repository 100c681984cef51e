"""The checks of motor_controller's parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from archo_tui.user_code.check import near_names
from archo_tui.user_code.check.check_runner import CheckRunner
from archo_tui.user_code.check.tap import Result

_DECLARED = "the parameters max_speed and wheel_radius are declared"
_LOADED = "parameters are loaded from a YAML file"
_WANTED = ("max_speed", "wheel_radius")
_EVERY_NODES = ("use_sim_time", "start_type_description_service")


def parameter_checks(runner: CheckRunner) -> Iterator[Result]:
    """Yield the outcome of the two checks: parameters are declared, and loaded from the file.

    The second compares wheel_radius with the `radius` of the runner; it is skipped if no node
    declares wheel_radius. The first is skipped if no node declares either parameter; it fails if
    one is missing, or a similar name is declared in its place.
    """
    known: dict[str, Any] = {
        name: value
        for node in runner.nodes()
        for name, value in node.parameters.items()
        if name not in _EVERY_NODES and not name.startswith("qos_overrides.")
    }
    missing = [name for name in _WANTED if name not in known]
    if len(missing) == len(_WANTED):
        title = " and ".join(_WANTED)
        results = [
            near_names.missing_result(runner, _DECLARED, name, "declare", "name", known)
            for name in _WANTED
        ]
        first = next((r for r in results if r.hint), results[0])
        yield first
        yield Result(_LOADED, skipped=f"no node declares {title}")
        return
    hints = []
    for name in missing:
        near = near_names.missing_result(runner, _DECLARED, name, "declare", "name", known).hint
        hints.append(near or f"not declared: {name}: self.declare_parameter({name!r}, value)")
    yield Result(_DECLARED, "\n".join(hints))
    if "wheel_radius" in missing:
        yield Result(_LOADED, skipped="no node declares wheel_radius")
        return
    radius = known["wheel_radius"]
    hint = (
        f"wheel_radius is {radius}, and the file says {runner.radius:g}: nothing may set it again"
    )
    yield Result(_LOADED, "" if radius == runner.radius else hint)
