"""The parts of launch that are not supported: each is left out, with a note that says why."""

from __future__ import annotations

from typing import Any

from archo_tui.launch.stand_ins.core import (
    Action,
    LaunchContext,
    LaunchDescription,
    SkipActionError,
    Substitution,
)

_PROGRAMS = "no other programs are started here: start it in another terminal"
_EVENTS = "launch's events are not followed here: what waits for one does not start"
_COMPONENTS = "components are written in C++: start them with ROS 2"
_COMMANDS = "no command is run here: what needs its output is left out"
_NEWER = "Jazzy has no such action: an OpaqueFunction returns several, too"
_PACKAGE = "its package is not here: what needs it is left out"

# The reason why each name of a module is not supported; None stands for every other name.
REASONS: dict[str, dict[str | None, str]] = {
    "launch": {
        "LaunchService": "this console performs the launch: leave it under __main__",
        "LaunchIntrospector": "this console performs the launch: leave it under __main__",
    },
    "launch.actions": {
        "EmitEvent": _EVENTS,
        "ForEach": _NEWER,
        "ForLoop": _NEWER,
        "ExecuteLocal": _PROGRAMS,
        "ExecuteProcess": _PROGRAMS,
        "OpaqueCoroutine": _EVENTS,
        "RegisterEventHandler": _EVENTS,
        "Shutdown": _EVENTS,
        "UnregisterEventHandler": _EVENTS,
    },
    "launch.event_handlers": {None: _EVENTS},
    "launch.events": {None: _EVENTS},
    "launch.events.process": {None: _EVENTS},
    "launch.substitutions": {
        "Command": _COMMANDS,
        "FindExecutable": _COMMANDS,
        "LaunchLogDir": "launch writes no log folder here",
        "LocalSubstitution": _EVENTS,
    },
    "launch_ros.actions": {
        "ComposableNodeContainer": _COMPONENTS,
        "LifecycleTransition": _EVENTS,
        "LoadComposableNodes": _COMPONENTS,
        "ROSTimer": _EVENTS,
        "RosTimer": _EVENTS,
        "SetROSLogDir": "this console has a log of its own",
        "SetUseSimTime": "it sets use_sim_time of launch itself: SetParameter sets it for nodes",
    },
    "launch_ros.descriptions": {"ComposableNode": _COMPONENTS},
    "launch_ros.event_handlers": {None: _EVENTS},
    "launch_ros.events": {None: _EVENTS},
    "launch_ros.events.lifecycle": {None: _EVENTS},
    "launch_ros.substitutions": {"ExecutableInPackage": _COMMANDS, "FindPackage": _COMMANDS},
    "launch_param_builder": {None: _PACKAGE},
    "moveit_configs_utils": {None: _PACKAGE},
    "nav2_common.launch": {None: _PACKAGE},
    "xacro": {None: "xacro is not run here: what needs its output is left out"},
}


class Absent(Action, Substitution):
    """The stand-in for a part of launch that is not supported, with any arguments.

    A call of one, and any public attribute that it lacks, gives the object itself. Its use in the
    evaluation raises SkipActionError.
    """

    reason = ""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(condition=options.get("condition"))

    def execute(self, context: LaunchContext) -> None:
        raise self._error()

    def perform(self, context: LaunchContext) -> str:
        raise self._error(is_value=True)

    def evaluate(self, context: LaunchContext) -> bool:
        raise self._error(is_value=True)

    def load(self, context: LaunchContext) -> tuple[str, LaunchDescription]:
        raise self._error()

    def _error(self, is_value: bool = False) -> SkipActionError:
        return SkipActionError(f"{type(self).__name__}: {self.reason}", self.place, is_value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "place":
            raise AttributeError(name)
        return self

    def __call__(self, *args: Any, **options: Any) -> Absent:
        return self


def absent_class(module: str, name: str) -> type[Absent] | None:
    """Return a new subclass of Absent for a name that is not supported; None for any other."""
    reasons = REASONS.get(module, {})
    reason = reasons.get(name, reasons.get(None))
    if reason is None or name.startswith("_"):
        return None
    return type(name, (Absent,), {"reason": reason, "__doc__": f"A stand-in: {reason}."})
