"""The files that a launch file includes: `launch.launch_description_sources`."""

from __future__ import annotations

import os
from pathlib import Path
from types import ModuleType
from typing import Any

from archo_tui import regular_files
from archo_tui.launch.stand_ins import ament_index
from archo_tui.launch.stand_ins.action import LaunchDescription
from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.failures import InvalidLaunchFileError, SkipActionError
from archo_tui.launch.stand_ins.places import Place, calling_place
from archo_tui.launch.stand_ins.substitution import (
    SomeSubstitutionsType,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = ["AnyLaunchDescriptionSource", "PythonLaunchDescriptionSource"]

_GENERATE = "generate_launch_description"

loaded_files: set[str] = set()  # The paths of the launch files, which errors are told of.


class PythonLaunchDescriptionSource:
    """A launch file in Python that another launch file includes."""

    def __init__(self, launch_file_path: SomeSubstitutionsType) -> None:
        self.place = calling_place()
        self._path = normalize_to_list_of_substitutions(launch_file_path)
        self._loaded: dict[str, LaunchDescription] = {}

    def load(self, context: LaunchContext) -> tuple[str, LaunchDescription]:
        """Return the path of the file, and what it describes; each path runs once only."""
        path = os.path.abspath(perform_substitutions(context, self._path))
        missing = ament_index.index.missing_package(path)
        if missing:
            text = f"{missing} is not here: start its {os.path.basename(path)} with ROS 2"
            raise SkipActionError(text, self.place)
        if not path.endswith(".py"):
            text = f"{os.path.basename(path)} is left out: only launch files in Python are read"
            raise SkipActionError(text, self.place)
        if not os.path.isfile(path):
            raise InvalidLaunchFileError(ament_index.index.why_missing(path), self.place)
        if path not in self._loaded:
            self._loaded[path] = load_launch_file(path)
        return path, self._loaded[path]


class AnyLaunchDescriptionSource(PythonLaunchDescriptionSource):
    """A launch file in any language, of which only Python is read: others are left out."""


def load_launch_file(path: str) -> LaunchDescription:
    """Run a launch file, and return what it describes; add its path to `loaded_files`."""
    loaded_files.add(path)
    module = ModuleType("python_launch_file")
    module.__file__ = path
    exec(compile(regular_files.read(Path(path)), path, "exec", dont_inherit=True), vars(module))
    generate: Any = vars(module).get(_GENERATE)
    if not callable(generate):
        raise InvalidLaunchFileError(f"it has no function {_GENERATE}()", Place(path, 1))
    description = generate()
    if not isinstance(description, LaunchDescription):
        line = getattr(getattr(generate, "__code__", None), "co_firstlineno", 1)
        text = f"{_GENERATE}() returns no LaunchDescription: end it with return LaunchDescription(["
        raise InvalidLaunchFileError(f"{text}...])", Place(path, line))
    return description
