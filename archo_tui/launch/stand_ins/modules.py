"""The stand-ins under the names that launch files import."""

from __future__ import annotations

import importlib
import logging
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
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


_CONTENTS: dict[str, Mapping[str, Any]] = {
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


class _Finder:
    """The import finder and loader of the stand-ins."""

    def __init__(self) -> None:
        found = packages.index.contents()
        self._contents = _CONTENTS | {
            "ament_index_python": found,
            "ament_index_python.packages": found,
            "ament_index_python.resources": _names(packages.index, "has_resource"),
        }

    def _is_known(self, name: str) -> bool:
        return _home(name) in self._contents or _home(name) in ABSENT

    def find_spec(self, name: str, path: Any, target: Any = None) -> ModuleSpec | None:
        loader: Any = self
        return ModuleSpec(name, loader, is_package=True) if self._is_known(name) else None

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None, so that Python makes an ordinary module."""

    def exec_module(self, module: ModuleType) -> None:
        home = _home(module.__name__)
        found = self._contents.get(home, {})

        def __getattr__(name: str) -> Any:  # PEP 562: what is not supported, or a module.
            if name.startswith("_"):
                raise AttributeError(name)
            if name.islower() and self._is_known(f"{module.__name__}.{name}"):
                return importlib.import_module(f"{module.__name__}.{name}")
            absent = absent_class(home, name)
            if absent is None:
                raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")
            setattr(module, name, absent)
            return absent

        everything = [*found, *(ABSENT.get(home, {}).keys() - {"*"})]  # For `import *`.
        module.__dict__.update(found, __all__=everything, __getattr__=__getattr__)


@contextmanager
def importable_stand_ins() -> Iterator[None]:
    """Let imports inside this context find the stand-ins instead of installed packages."""

    def ours() -> list[str]:
        return [name for name in sys.modules if name.partition(".")[0] in _FAMILIES]

    hidden = {name: sys.modules.pop(name) for name in ours()}
    finder: Any = _Finder()
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name in ours():
            del sys.modules[name]
        sys.modules.update(hidden)


def _home(name: str) -> str:
    """Return the package of a class's own module, which editors import from: `launch.actions`.

    Any other module is its own.
    """
    parent, _, last = name.rpartition(".")
    is_known = (
        name in _CONTENTS or name in ABSENT or not name.startswith(("launch.", "launch_ros."))
    )
    return name if is_known or not last.islower() else parent
