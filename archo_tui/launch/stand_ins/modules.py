"""The stand-ins under the names that launch files import."""

from __future__ import annotations

import logging
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import ModuleType
from typing import Any

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
from archo_tui.launch.stand_ins.absent import REASONS, absent_class

_INDEX = {
    name: vars(packages)[name]
    for name in (
        *("PackageNotFoundError", "get_package_prefix", "get_package_share_directory"),
        *("get_package_share_path", "get_packages_with_prefixes"),
    )
}
_SUBSTITUTION = {
    name: vars(core)[name]
    for name in ("Substitution", "SomeSubstitutionsType", "normalize_to_list_of_substitutions")
}


def _public(module: ModuleType) -> dict[str, Any]:
    names: list[str] = vars(module)["__all__"]
    return {name: vars(module)[name] for name in names}


_CONTENTS: Mapping[str, Mapping[str, Any]] = {
    "ament_index_python": _INDEX,
    "ament_index_python.packages": _INDEX,
    "ament_index_python.resources": {"has_resource": packages.has_resource},
    "launch": {
        "Action": core.Action,
        "Condition": core.Condition,
        "LaunchContext": core.LaunchContext,
        "LaunchDescription": core.LaunchDescription,
        "LaunchDescriptionEntity": core.LaunchDescriptionEntity,
        "SomeSubstitutionsType": Any,
        "Substitution": core.Substitution,
    },
    "launch.action": {"Action": core.Action},
    "launch.actions": _public(actions),
    "launch.condition": {"Condition": core.Condition},
    "launch.conditions": _public(conditions),
    "launch.launch_context": {"LaunchContext": core.LaunchContext},
    "launch.launch_description": {"LaunchDescription": core.LaunchDescription},
    "launch.launch_description_entity": {"LaunchDescriptionEntity": core.LaunchDescriptionEntity},
    "launch.launch_description_sources": _public(sources),
    "launch.logging": {"get_logger": logging.getLogger},
    "launch.some_substitutions_type": {"SomeSubstitutionsType": Any},
    "launch.substitution": _SUBSTITUTION,
    "launch.substitutions": _public(substitutions),
    "launch.utilities": {
        "normalize_to_list_of_substitutions": core.normalize_to_list_of_substitutions,
        "perform_substitutions": core.perform_substitutions,
    },
    "launch_ros": {},
    "launch_ros.actions": _public(ros_actions),
    "launch_ros.descriptions": _public(values),
    "launch_ros.parameter_descriptions": _public(values),
    "launch_ros.substitutions": {n: vars(substitutions)[n] for n in substitutions.OF_ROS},
    "launch_xml": {},
    "launch_xml.launch_description_sources": {
        "XMLLaunchDescriptionSource": sources.XMLLaunchDescriptionSource
    },
    "launch_yaml": {},
    "launch_yaml.launch_description_sources": {
        "YAMLLaunchDescriptionSource": sources.YAMLLaunchDescriptionSource
    },
    # Its modules are absent.
    "nav2_common": {},
}


# The packages in which each class has a module of its own, which editors import it from.
_SPLIT = (
    *("launch.actions", "launch.conditions", "launch.launch_description_sources"),
    *("launch.substitutions", "launch_ros.actions"),
)


@contextmanager
def importable_stand_ins() -> Iterator[None]:
    """Let imports inside this context find the stand-ins instead of installed packages."""
    modules = {name: _module(name, name) for name in dict.fromkeys([*_CONTENTS, *REASONS])}
    for package in _SPLIT:
        for name in vars(modules[package])["__all__"]:
            own = f"{package}.{_snake_case(name)}"
            modules[own] = _module(own, package)
    for name, module in modules.items():
        parent, _, last = name.rpartition(".")
        if parent:
            setattr(modules[parent], last, module)
    families = tuple({name.partition(".")[0] for name in modules})
    hidden = {name: sys.modules.pop(name) for name in list(sys.modules) if _is_of(name, families)}
    sys.modules.update(modules)
    try:
        yield
    finally:
        for name in [name for name in sys.modules if _is_of(name, families)]:
            del sys.modules[name]
        sys.modules.update(hidden)


def _is_of(name: str, families: tuple[str, ...]) -> bool:
    return name.partition(".")[0] in families


def _snake_case(name: str) -> str:
    """Return the name of a class's module: `set_remap` for `SetRemap`."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def _module(name: str, contents_of: str) -> ModuleType:
    """Return a new module with stand-ins; what is not supported is a subclass of Absent."""
    module = ModuleType(name)

    def __getattr__(attribute: str) -> Any:  # PEP 562: what is not here, by its name.
        found = absent_class(contents_of, attribute)
        if found is None:
            raise AttributeError(f"module {name!r} has no attribute {attribute!r}")
        setattr(module, attribute, found)
        return found

    contents = _CONTENTS.get(contents_of, {})
    everything = [*contents, *filter(None, REASONS.get(contents_of, {}))]  # For `import *`.
    # Without a path, nothing of an installed package of the name is found.
    module.__dict__.update(contents, __path__=[], __all__=everything, __getattr__=__getattr__)
    return module
