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


_OF_INDEX = _names(
    packages,
    *("PackageNotFoundError", "get_package_prefix", "get_package_share_directory"),
    *("get_package_share_path", "get_packages_with_prefixes"),
)
_CONTENTS: dict[str, ModuleContents] = {
    "ament_index_python": _OF_INDEX,
    "ament_index_python.packages": _OF_INDEX,
    "ament_index_python.resources": _names(packages, "has_resource"),
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
_FAMILIES = {name.partition(".")[0] for name in [*_CONTENTS, *ABSENT]}


def importable_stand_ins() -> AbstractContextManager[None]:
    """Let imports inside this context find the stand-ins instead of installed packages."""
    return importable(_FAMILIES, _contents, lambda name, what: absent_class(_home(name), what))


def _home(name: str) -> str:
    """Return the package of a class's own module, which editors import from: `launch.actions`.

    Any other module is its own.
    """
    parent, _, last = name.rpartition(".")
    is_known = (
        name in _CONTENTS or name in ABSENT or not name.startswith(("launch.", "launch_ros."))
    )
    return name if is_known or not last.islower() else parent


def _contents(name: str) -> ModuleContents | None:
    """Return the names of a module, with those that are not supported for `import *`."""
    home = _home(name)
    if home not in _CONTENTS and home not in ABSENT:
        return None
    found = _CONTENTS.get(home, {})
    named = ABSENT.get(home, {}).keys() - {"*"}
    return {**found, "__all__": [*found, *named]}
