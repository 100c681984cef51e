"""The stand-ins under the names that launch files import."""

from __future__ import annotations

import logging
from contextlib import AbstractContextManager
from types import ModuleType
from typing import Any

from archo_tui.launch.import_stand_ins import ModuleContents, importable
from archo_tui.launch.stand_ins import (
    actions,
    conditions,
    core,
    packages,
    ros_actions,
    sources,
    substitutions,
    values,
)
from archo_tui.launch.stand_ins.absent import ABSENT, absent_class


def _names(of: Any, *names: str) -> dict[str, Any]:
    return {name: getattr(of, name) for name in names}


def _classes(module: ModuleType) -> dict[str, Any]:
    """Return the public classes that a module defines."""
    return {
        name: value
        for name, value in vars(module).items()
        if getattr(value, "__module__", "") == module.__name__
        and isinstance(value, type)
        and not name.startswith("_")
    }


_CONTENTS: dict[str, ModuleContents] = {
    "launch": _names(
        core,
        *("Action", "Condition", "LaunchContext", "LaunchDescription", "LaunchDescriptionEntity"),
        *("SomeSubstitutionsType", "Substitution"),
    ),
    "launch.actions": _classes(actions),
    "launch.conditions": _classes(conditions),
    "launch.launch_description_sources": _classes(sources),
    "launch.logging": {"get_logger": logging.getLogger},
    "launch.substitutions": {
        **_classes(substitutions),
        **_names(core, "SubstitutionFailure", "TextSubstitution"),
    },
    "launch.utilities": _names(core, "normalize_to_list_of_substitutions", "perform_substitutions"),
    "launch_ros": {},
    "launch_ros.actions": _classes(ros_actions),
    "launch_ros.descriptions": _classes(values),
    "launch_ros.parameter_descriptions": _classes(values),
    "launch_ros.substitutions": _names(packages, "FindPackagePrefix", "FindPackageShare"),
    "launch_xml": {},
    "launch_xml.launch_description_sources": _names(sources, "XMLLaunchDescriptionSource"),
    "launch_yaml": {},
    "launch_yaml.launch_description_sources": _names(sources, "YAMLLaunchDescriptionSource"),
    "nav2_common": {},
}
_FAMILIES = {name.partition(".")[0] for name in [*_CONTENTS, *ABSENT]} | {"ament_index_python"}


def importable_stand_ins() -> AbstractContextManager[None]:
    """Let imports inside this context find the stand-ins instead of installed packages."""
    found = packages.index.contents()
    contents = _CONTENTS | {
        "ament_index_python": found,
        "ament_index_python.packages": found,
        "ament_index_python.resources": _names(packages.index, "has_resource"),
    }

    def contents_of(name: str) -> ModuleContents | None:
        """Return the names of a module, with those that are not supported for `import *`."""
        home = _home(name)
        if home not in contents and home not in ABSENT:
            return None
        absent = ABSENT.get(home, {}).keys() - {"*"}
        return {**contents.get(home, {}), "__all__": [*contents.get(home, ()), *absent]}

    return importable(_FAMILIES, contents_of, lambda name, what: absent_class(_home(name), what))


def _home(name: str) -> str:
    """Return the package of a class's own module, which editors import from: `launch.actions`.

    Any other module is its own.
    """
    parent, _, last = name.rpartition(".")
    is_known = (
        name in _CONTENTS or name in ABSENT or not name.startswith(("launch.", "launch_ros."))
    )
    return name if is_known or not last.islower() else parent
