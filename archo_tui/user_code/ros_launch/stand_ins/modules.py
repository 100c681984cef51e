"""The stand-ins under the names that launch files import."""

from __future__ import annotations

import logging
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from archo_tui.user_code.ros_launch.stand_ins import (
    actions,
    core,
    packages,
    ros_actions,
    substitutions,
)
from archo_tui.user_code.ros_launch.stand_ins.core import (
    Action,
    Condition,
    LaunchContext,
    LaunchDescription,
    SkipActionError,
    Substitution,
)


def _names(of: Any, *names: str) -> dict[str, Any]:
    return {name: getattr(of, name) for name in names}


def _classes(module: ModuleType, base: type) -> dict[str, Any]:
    """Return the public classes of a kind that a module defines."""
    return {
        name: value
        for name, value in vars(module).items()
        if isinstance(value, type)
        and issubclass(value, base)
        and value.__module__ == module.__name__
        and not name.startswith("_")
    }


_PARAMETERS = _names(ros_actions, "Parameter", "ParameterFile", "ParameterValue")
_CONTENTS: dict[str, Mapping[str, Any]] = {
    "launch": _names(
        core,
        *("Action", "Condition", "LaunchContext", "LaunchDescription", "LaunchDescriptionEntity"),
        *("SomeSubstitutionsType", "Substitution"),
    ),
    "launch.actions": _classes(actions, Action),
    "launch.conditions": _classes(actions, Condition),
    "launch.launch_description_sources": _classes(actions, actions.AnyLaunchDescriptionSource),
    "launch.logging": {"get_logger": logging.getLogger},
    "launch.substitutions": {
        **_classes(substitutions, Substitution),
        **_names(core, "SubstitutionFailure", "TextSubstitution"),
    },
    "launch.utilities": _names(core, "normalize_to_list_of_substitutions", "perform_substitutions"),
    "launch_ros": {},
    "launch_ros.actions": {
        **_classes(ros_actions, Action),
        "PushRosNamespace": ros_actions.PushROSNamespace,
    },
    "launch_ros.descriptions": _PARAMETERS,
    "launch_ros.parameter_descriptions": _PARAMETERS,
    "launch_ros.substitutions": _names(packages, "FindPackagePrefix", "FindPackageShare"),
    "launch_xml": {},
    "launch_xml.launch_description_sources": _names(actions, "XMLLaunchDescriptionSource"),
    "launch_yaml": {},
    "launch_yaml.launch_description_sources": _names(actions, "YAMLLaunchDescriptionSource"),
    "nav2_common": {},
}
# What does not run here, by module; in one without names nothing does.
_ABSENT = {
    module: names.split()
    for module, names in {
        "launch": "LaunchIntrospector LaunchService",
        "launch.actions": "EmitEvent ExecuteLocal ExecuteProcess ForEach ForLoop OpaqueCoroutine "
        "PopEnvironment PopLaunchConfigurations PushEnvironment PushLaunchConfigurations "
        "RegisterEventHandler ResetEnvironment ResetLaunchConfigurations Shutdown "
        "UnregisterEventHandler UnsetLaunchConfiguration",
        "launch.event_handlers": "OnExecutionComplete OnProcessExit OnProcessIO OnProcessStart "
        "OnShutdown",
        "launch.events": "",
        "launch.events.process": "",
        "launch.substitutions": "AllSubstitution AnonName AnySubstitution Command "
        "FindExecutable LaunchLogDir LocalSubstitution",
        "launch_param_builder": "",
        "launch_ros.actions": "ComposableNodeContainer LifecycleTransition "
        "LoadComposableNodes ROSTimer RosTimer SetROSLogDir SetUseSimTime",
        "launch_ros.descriptions": "ComposableNode",
        "launch_ros.event_handlers": "OnStateTransition",
        "launch_ros.events": "",
        "launch_ros.events.lifecycle": "",
        "launch_ros.substitutions": "ExecutableInPackage FindPackage Parameter",
        "moveit_configs_utils": "",
        "nav2_common.launch": "",
        "xacro": "",
    }.items()
}
_FAMILIES = {name.partition(".")[0] for name in [*_CONTENTS, *_ABSENT]} | {"ament_index_python"}
_CAPITAL = re.compile("(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")  # It begins a word.


class Absent(Action, Substitution):
    """The stand-in for a part of launch that does not run here, with any arguments.

    A call of one, and any public attribute that it lacks, gives the object itself. Its use in the
    evaluation raises SkipActionError.
    """

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
        text = f"{type(self).__name__} does not run here, nor what needs it: ROS 2 runs it"
        return SkipActionError(text, self.place)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "place":
            raise AttributeError(name)
        return self

    def __call__(self, *args: Any, **options: Any) -> Absent:
        return self


def absent_class(name: str) -> type[Absent]:
    """Return a new subclass of Absent with a name."""
    return type(name, (Absent,), {"__doc__": "A part of launch that does not run here."})


def _modules() -> Iterator[tuple[str, ModuleType]]:
    """Yield the stand-ins by their names, also the modules of classes, which editors import."""
    index = packages.index.contents()
    found = {
        "ament_index_python": index,
        "ament_index_python.packages": index,
        "ament_index_python.resources": _names(packages.index, "has_resource"),
        **_CONTENTS,
    }
    for name in [*found, *(_ABSENT.keys() - found)]:
        module, absent = ModuleType(name), _ABSENT.get(name)
        contents = {**found.get(name, {}), **{each: absent_class(each) for each in absent or ()}}
        module.__dict__.update(contents, __path__=[])
        if absent == []:
            module.__dict__["__getattr__"] = _absent_attribute
        yield name, module
        for each in contents:
            yield f"{name}.{_CAPITAL.sub('_', each).lower()}", module


def _absent_attribute(name: str) -> type[Absent]:
    if name.startswith("_"):
        raise AttributeError(name)
    return absent_class(name)


@contextmanager
def importable_stand_ins() -> Iterator[None]:
    """Let imports inside this context find the stand-ins instead of installed packages."""

    def ours() -> list[str]:
        return [name for name in sys.modules if name.partition(".")[0] in _FAMILIES]

    hidden = {name: sys.modules.pop(name) for name in ours()}
    for name, module in _modules():
        sys.modules[name] = module
        parent, _, last = name.rpartition(".")
        if module.__name__ == name and parent in sys.modules:
            setattr(sys.modules[parent], last, module)
    try:
        yield
    finally:
        for name in ours():
            del sys.modules[name]
        sys.modules.update(hidden)
