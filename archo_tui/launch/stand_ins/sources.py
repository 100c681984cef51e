"""The files that a launch file includes: `launch.launch_description_sources`."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from archo_tui import regular_files
from archo_tui.launch.stand_ins import packages
from archo_tui.launch.stand_ins.core import (
    LaunchContext,
    LaunchDescription,
    Made,
    Place,
    SkipActionError,
    SubstitutionFailure,
    Text,
    perform,
)

_GENERATE = "generate_launch_description"

# Of other languages than Python, by the ends of names; the evaluation adds them, since they need
# all actions, of which one includes files.
LOADERS: dict[str, Callable[[str], LaunchDescription]] = {}
loaded_files: set[str] = set()  # The paths of the launch files, which errors are told of.


@dataclass(eq=False)
class AnyLaunchDescriptionSource(Made):
    """A launch file in Python, XML or YAML that another launch file includes."""

    launch_file_path: Text

    def __post_init__(self) -> None:
        super().__post_init__()
        self._loaded: dict[str, LaunchDescription] = {}

    def load(self, context: LaunchContext) -> tuple[str, LaunchDescription]:
        """Return the path of the file, and what it describes; each path runs once only."""
        path = os.path.abspath(perform(context, self.launch_file_path))
        missing = packages.index.missing_package(path)
        if missing:
            text = f"{missing} is not here: start its {os.path.basename(path)} with ROS 2"
            raise SkipActionError(text)
        if not self._takes(path):
            text = f"{os.path.basename(path)} is not for {type(self).__name__}"
            hint = "AnyLaunchDescriptionSource takes each kind"
            raise SubstitutionFailure(f"{text}: {hint}", self.place)
        if not os.path.isfile(path):
            raise SubstitutionFailure(packages.index.why_missing(path), self.place)
        if path not in self._loaded:
            self._loaded[path] = load_launch_file(path)
        return path, self._loaded[path]

    def _takes(self, _path: str) -> bool:
        return True


class PythonLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in Python that another launch file includes."""

    def _takes(self, path: str) -> bool:
        return path.endswith(".py")


class FrontendLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in XML or YAML that another launch file includes."""

    def _takes(self, path: str) -> bool:
        return not path.endswith(".py")


class XMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A launch file in XML that another launch file includes."""


class YAMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A launch file in YAML that another launch file includes."""


def load_launch_file(path: str) -> LaunchDescription:
    """Run or read a launch file, and return what it describes; add its path to `loaded_files`."""
    loaded_files.add(path)
    return LOADERS.get(os.path.splitext(path)[1], _run)(path)


def _run(path: str) -> LaunchDescription:
    module = ModuleType("python_launch_file")
    module.__file__ = path
    exec(compile(regular_files.read(Path(path)), path, "exec", dont_inherit=True), vars(module))
    generate: Any = vars(module).get(_GENERATE)
    if not callable(generate):
        raise SubstitutionFailure(f"it has no function {_GENERATE}()", Place(path, 1))
    description = generate()
    if not isinstance(description, LaunchDescription):
        line = getattr(getattr(generate, "__code__", None), "co_firstlineno", 1)
        text = f"{_GENERATE}() returns no LaunchDescription: end it with return LaunchDescription(["
        raise SubstitutionFailure(f"{text}...])", Place(path, line))
    return description
