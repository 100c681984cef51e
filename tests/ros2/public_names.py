"""Prints the public names of `rclpy`, and of its classes, as JSON; `embedded` for the engine's.

`reexported`: instead, the names that its modules have only because they import them. `imports`:
those of the names on standard input, `module.name`, that the embedded engine does not answer for.
"""

from __future__ import annotations

import importlib
import inspect
import json
import pkgutil
import sys
import types
import typing
from collections.abc import Iterator


def modules() -> Iterator[types.ModuleType]:
    """rclpy and its public modules."""
    import rclpy

    yield rclpy
    for found in pkgutil.walk_packages(rclpy.__path__, "rclpy."):
        if not any(part.startswith("_") for part in found.name.split(".")):
            yield importlib.import_module(found.name)


def own(module: types.ModuleType, name: str) -> bool:
    """True for what the module defines, or names anew, and not for what it imports to use it."""
    value = getattr(module, name, None)
    home = str(getattr(value, "__module__", module.__name__))
    if isinstance(value, (types.ModuleType, typing.TypeVar)) or home in ("typing", "types"):
        return False
    if name in getattr(module, "__all__", ()) or home == module.__name__:
        return True
    if "_rclpy_pybind11" in home:
        return getattr(value, "__name__", "") != name
    return not (inspect.isclass(value) or inspect.isfunction(value))


def methods(kind: type) -> set[str]:
    """The public methods of a class, but for those that every dict, exception or number has."""
    common = {name for base in (dict, Exception, tuple, int) for name in dir(base)}
    found = {name for name in dir(kind) if name[0] != "_" and callable(getattr(kind, name))}
    return found - common


def names() -> set[str]:
    """`rclpy.node.Node.create_timer`, and so on."""
    found = set()
    for module in modules():
        listed = getattr(module, "__all__", None) or [n for n in vars(module) if n[0] != "_"]
        for name in filter(lambda name: own(module, name), listed):
            full, value = f"{module.__name__}.{name}", getattr(module, name)
            found.add(full)
            if inspect.isclass(value):
                found |= {f"{full}.{method}" for method in methods(value)}
    return found


def reexported() -> set[str]:
    """`rclpy.node.ReentrantCallbackGroup`, and so on: functions, classes and interfaces of ROS."""
    found = set()
    for module in modules():
        for name, value in vars(module).items():
            home = getattr(value, "__module__", None) or ""
            is_ros = home.split(".")[0] in ("rclpy", "rcl_interfaces")
            is_kind = inspect.isclass(value) or inspect.isfunction(value)
            if name[0] != "_" and is_ros and is_kind and home != module.__name__:
                found.add(f"{module.__name__}.{name}")
    return found


def is_answered(full: str) -> bool:
    """True when that can be imported, or the error says that real ROS 2 has it."""
    module, _, name = full.rpartition(".")
    try:
        getattr(importlib.import_module(module), name)
    except ImportError as error:
        return "real ROS 2 has it" in str(error)
    except AttributeError:
        return False
    return True


if __name__ == "__main__":
    wanted = "".join(sys.argv[1:])
    if wanted in ("embedded", "imports"):
        from archo_tui import engine

        engine.activate("embedded")
    if wanted == "imports":
        found = {full for full in json.load(sys.stdin) if not is_answered(full)}
    else:
        found = reexported() if wanted == "reexported" else names()
    print(json.dumps(sorted(found)))
