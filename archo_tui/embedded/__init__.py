"""ROS 2 without ROS: an in-process `rclpy` and the interface packages it needs.

The engine knows nothing of ARCHO and of the console; it imports the standard library, PyYAML and
the reader of YAML text only. `install()` makes `import rclpy` mean the package beside this file.
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

RELEASE = "kilted"  # The release of ROS 2 whose rclpy this is a part of.
HERE = Path(__file__).parent


class RclpyLoader(importlib.machinery.SourceFileLoader):
    """The loader of those modules of rclpy that re-export names, or whose names are incomplete.

    A module gets the `__getattr__` of `absent.lookup_in`: it finds the re-exported names, and
    raises ImportError for those that the engine leaves out.
    """

    def exec_module(self, module: ModuleType) -> None:
        module.__getattr__ = absent.lookup_in(module.__name__)  # type: ignore[method-assign]
        super().exec_module(module)


class RclpyFinder:
    """The import finder that makes `import rclpy` mean the embedded package.

    A module of rclpy that the engine leaves out raises ImportError, which says that real ROS 2 has
    it.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        absent.check_module(fullname)
        if not absent.answers_for(fullname):
            return None
        folder = HERE.joinpath(*fullname.split("."))
        is_package = folder.is_dir()
        file = folder / "__init__.py" if is_package else folder.with_suffix(".py")
        return importlib.util.spec_from_file_location(
            fullname,
            file,
            loader=RclpyLoader(fullname, str(file)),
            submodule_search_locations=[str(folder)] if is_package else None,
        )


def is_installed() -> bool:
    """Return True if `import rclpy` means the embedded engine in this process."""
    return any(isinstance(finder, RclpyFinder) for finder in sys.meta_path)


def finder(
    packages: Mapping[str, Path] | None = None, own: Mapping[str, Path] | None = None
) -> InterfaceFinder:
    """Return an import finder of the interface packages that `install` makes importable.

    Nothing is installed; the arguments are those of `install`.
    """
    return InterfaceFinder(HERE / "share", packages or {}, own)


def install(
    packages: Mapping[str, Path] | None = None, own: Mapping[str, Path] | None = None
) -> None:
    """Make `import rclpy` mean the embedded engine, and interface packages importable.

    Both finders are put in front of all others in `sys.meta_path`. A second call does nothing,
    whatever its arguments are.

    Args:
        packages: Interface packages by name (`{"archo_interfaces": Path("interfaces")}`), besides
            those in `share/` and on AMENT_PREFIX_PATH.
        own: The user's packages by name, whose files are taken before any other's.

    Raises:
        RuntimeError: Another `rclpy` has been imported already; one name must not have two meanings
            in one process.
    """
    if is_installed():
        return
    other = sys.modules.get("rclpy")
    if other is not None:
        raise RuntimeError(f"another rclpy is already imported: {other.__file__}")
    sys.meta_path.insert(0, finder(packages, own))
    sys.meta_path.insert(0, RclpyFinder())
