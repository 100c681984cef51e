"""ROS 2 without ROS: an in-process `rclpy` and the interface packages it needs.

The engine knows nothing of ARCHO and of the console; it imports the standard library, PyYAML and
the reader of YAML text only. `install()` makes `import rclpy` mean the package beside this file.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import opcode
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from .import_hook import InterfaceFinder

HERE = Path(__file__).parent


# Where a name is looked for that a module lacks: rclpy's modules have what they import, too, and
# programs import it from there, as in `from rclpy.node import ReentrantCallbackGroup`.
_HOMES = (
    *("rclpy.callback_groups", "rclpy.qos", "rclpy.parameter", "rclpy.clock", "rclpy.executors"),
    *("rclpy.task", "rclpy.context", "rclpy.event_handler", "rclpy.exceptions", "rclpy.node"),
    *("rclpy.logging", "rclpy.duration", "rclpy.type_support", "rclpy.utilities", "rclpy.signals"),
    *("rclpy.constants", "rcl_interfaces.msg", "action_msgs.msg"),
)


def _absent(name: str) -> str:
    return f"the embedded engine has no {name}: if real ROS 2 has it, use archo-tui --engine ros2"


def _lookup(module: str, name: str) -> Any:
    """Return what another module of rclpy has by a name, as the `__getattr__` of a module.

    ImportError is raised in a `from` import, whose error would else not be shown.
    """
    homes = () if name.startswith("_") else map(importlib.import_module, _HOMES)
    for home in homes:
        # A class of an interface package is made at its first use; until then, only __all__ has it.
        if name in vars(home) or name in vars(home).get("__all__", ()):
            return getattr(home, name)
    frame = sys._getframe(1)
    is_import = frame.f_code.co_code[frame.f_lasti] == opcode.opmap["IMPORT_FROM"]
    raise (ImportError if is_import else AttributeError)(_absent(f"{module}.{name}"))


class RclpyLoader(importlib.machinery.SourceFileLoader):
    """The loader of rclpy's modules, in which names are looked up that they lack."""

    def exec_module(self, module: ModuleType) -> None:
        super().exec_module(module)
        module.__getattr__ = partial(_lookup, module.__name__)  # type: ignore[method-assign]


class RclpyFinder:
    """The import finder that makes `import rclpy` mean the embedded package.

    A module that the engine lacks raises ImportError, which names real ROS 2.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname.partition(".")[0] != "rclpy":
            return None
        folder = HERE.joinpath(*fullname.split("."))
        is_package = folder.is_dir()
        file = folder / "__init__.py" if is_package else folder.with_suffix(".py")
        if not file.is_file():
            raise ImportError(_absent(fullname), name=fullname)
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
    """
    if is_installed():
        return
    other = sys.modules.get("rclpy")
    if other is not None:
        raise RuntimeError(f"another rclpy is already imported: {other.__file__}")
    sys.meta_path.insert(0, finder(packages, own))
    sys.meta_path.insert(0, RclpyFinder())
