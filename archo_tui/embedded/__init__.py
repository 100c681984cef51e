"""ROS 2 without ROS: an in-process `rclpy` and the interface packages it needs.

Knows nothing of ARCHO and nothing of the console; imports the standard library
and PyYAML only. `install()` makes `import rclpy` mean the package beside this file.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType

from . import absent
from .import_hook import InterfaceFinder

HERE = Path(__file__).parent


class RclpyFinder:
    """Answers `import rclpy` with the embedded package; submodules follow from its `__path__`."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        absent.check_module(fullname)
        if fullname != "rclpy":
            return None
        folder = HERE / "rclpy"
        return importlib.util.spec_from_file_location(
            "rclpy", folder / "__init__.py", submodule_search_locations=[str(folder)]
        )


def is_installed() -> bool:
    """True when `import rclpy` means the embedded engine in this process."""
    return any(isinstance(finder, RclpyFinder) for finder in sys.meta_path)


def finder(
    packages: Mapping[str, Path] | None = None, own: Mapping[str, Path] | None = None
) -> InterfaceFinder:
    """Finds the same interfaces as `install` does."""
    return InterfaceFinder(HERE / "share", packages or {}, own)


def install(
    packages: Mapping[str, Path] | None = None, own: Mapping[str, Path] | None = None
) -> None:
    """Put the embedded `rclpy` and the interface packages in front of every other.

    `packages` names interface packages by folder (`{"archo_interfaces": Path("interfaces")}`),
    beside those in `share/` and on AMENT_PREFIX_PATH; `own` those of the user, whose files are
    taken before any other's. Installing twice changes nothing.

    Raises RuntimeError when another `rclpy` has been imported already: two meanings of one
    name in one process would be worse than none.
    """
    if is_installed():
        return
    other = sys.modules.get("rclpy")
    if other is not None:
        raise RuntimeError(f"another rclpy is already imported: {other.__file__}")
    sys.meta_path.insert(0, finder(packages, own))
    sys.meta_path.insert(0, RclpyFinder())
