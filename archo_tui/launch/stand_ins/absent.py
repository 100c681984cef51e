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

_PERFORMS = "this console performs the launch: leave it under __main__"
_PROGRAMS = "no other programs are started here: start it in another terminal"
_EVENTS = "launch's events are not followed here: what waits for one does not start"
_COMPONENTS = "components are written in C++: start them with ROS 2"
_COMMANDS = "no command is run here: what needs its output is left out"
_LOGS = "this console has a log of its own"
_NEWER = "Jazzy has no such action: an OpaqueFunction returns several, too"
_PACKAGE = "its package is not here: what needs it is left out"
_SET = "what SetParameter has set is not read here: use a LaunchConfiguration"
_SIM_TIME = "it sets use_sim_time of launch itself: SetParameter sets it for nodes"

_ALL = "*"
# Why names of a module are not supported.
_REASONS = (
    ("launch", "LaunchIntrospector LaunchService", _PERFORMS),
    ("launch.actions", "ExecuteLocal ExecuteProcess", _PROGRAMS),
    ("launch.actions", "EmitEvent OpaqueCoroutine RegisterEventHandler Shutdown", _EVENTS),
    ("launch.actions", "UnregisterEventHandler", _EVENTS),
    ("launch.actions", "ForEach ForLoop", _NEWER),
    ("launch.event_handlers", _ALL, _EVENTS),
    ("launch.events", _ALL, _EVENTS),
    ("launch.substitutions", "Command FindExecutable", _COMMANDS),
    ("launch.substitutions", "LaunchLogDir", _LOGS),
    ("launch.substitutions", "LocalSubstitution", _EVENTS),
    ("launch_param_builder", _ALL, _PACKAGE),
    ("launch_ros.actions", "ComposableNodeContainer LoadComposableNodes", _COMPONENTS),
    ("launch_ros.actions", "LifecycleTransition ROSTimer RosTimer", _EVENTS),
    ("launch_ros.actions", "SetROSLogDir", _LOGS),
    ("launch_ros.actions", "SetUseSimTime", _SIM_TIME),
    ("launch_ros.descriptions", "ComposableNode", _COMPONENTS),
    ("launch_ros.event_handlers", _ALL, _EVENTS),
    ("launch_ros.events", _ALL, _EVENTS),
    ("launch_ros.substitutions", "ExecutableInPackage FindPackage", _COMMANDS),
    ("launch_ros.substitutions", "Parameter", _SET),
    ("moveit_configs_utils", _ALL, _PACKAGE),
    ("nav2_common.launch", _ALL, _PACKAGE),
    ("xacro", _ALL, "xacro is not run here: what needs its output is left out"),
)
ABSENT: dict[str, dict[str, str]] = {}  # By module and name, the reason.
for _module, _names, _reason in _REASONS:
    ABSENT.setdefault(_module, {}).update(dict.fromkeys(_names.split(), _reason))


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
        raise self._error()

    def evaluate(self, context: LaunchContext) -> bool:
        raise self._error()

    def load(self, context: LaunchContext) -> tuple[str, LaunchDescription]:
        raise self._error()

    def _error(self) -> SkipActionError:
        return SkipActionError(f"{type(self).__name__}: {self.reason}", self.place)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "place":
            raise AttributeError(name)
        return self

    def __call__(self, *args: Any, **options: Any) -> Absent:
        return self


def absent_class(module: str, name: str) -> type[Absent] | None:
    """Return a new subclass of Absent for a name that is not supported; None for any other."""
    reasons = ABSENT.get(module, {})
    reason = reasons.get(name) or reasons.get(_ALL)
    if reason is None:
        return None
    return type(name, (Absent,), {"reason": reason, "__doc__": f"A stand-in: {reason}."})
