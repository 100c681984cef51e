"""An import hook: `from archo_interfaces.msg import BatteryStatus` reads `BatteryStatus.msg`.

A package is a folder with `msg/`, `srv/` or `action/` in it. Each file is looked for, in this
order, in the folders of the user's own, in those given by name, `share/` beside this file, and
`share/<package>/` of each prefix on AMENT_PREFIX_PATH: a package that is whole there completes one
that is partial here.
Classes are made at their first use.
"""

from __future__ import annotations

import importlib.machinery
import os
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from .idl import Field, InterfaceError, Section, parse
from .messages import make_action, make_message, make_service

KINDS = ("msg", "srv", "action")
NEEDED = (  # rclpy itself uses these; a user's copy with other fields would break it.
    *("action_msgs", "builtin_interfaces", "lifecycle_msgs", "rcl_interfaces"),
    *("rosgraph_msgs", "unique_identifier_msgs"),
)


class InterfaceFinder:
    """The import finder of interface packages, and the loader of their modules.

    Every class is made once, at its first use, on whichever thread that is.
    """

    def __init__(
        self, share: Path, packages: Mapping[str, Path], own: Mapping[str, Path] | None = None
    ) -> None:
        self._share = share
        self._packages, self._own = dict(packages), dict(own or {})
        self._classes: dict[str, Any] = {}
        self._making: list[str] = []  # Types being made; each contains the next one.
        self._lock = threading.RLock()  # Nodes on several threads import classes.

    def folders(self, package: str) -> list[Path]:
        """Return the existing folders of a package with msg/, srv/ or action/, in search order."""
        prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        candidates = [
            self._own.get(package),
            self._packages.get(package),
            self._share / package,
            *(Path(prefix) / "share" / package for prefix in prefixes if prefix),
        ]
        return [p for p in candidates if p is not None and has_interfaces(p)]

    def names(self, package: str, kind: str) -> list[str]:
        """Return the sorted names of the interfaces that a package has in all its folders."""
        found = (path.stem for f in self.folders(package) for path in f.glob(f"{kind}/*.{kind}"))
        return sorted(set(found))

    def load(self, type_name: str) -> Any:
        """Return the class of "package/kind/Name", made at the first call."""
        with self._lock:
            if type_name not in self._classes:
                self._making.append(type_name)
                try:
                    self._classes[type_name] = self._make(type_name)
                finally:
                    self._making.pop()
            return self._classes[type_name]

    def _make(self, type_name: str) -> Any:
        package, kind, name = type_name.split("/")
        paths = [folder / kind / f"{name}.{kind}" for folder in self.folders(package)]
        path = next((path for path in paths if path.is_file()), None)
        if path is None:
            looked = ", ".join(map(str, paths)) or package
            raise ImportError(f"no interface {type_name}: looked for {looked}")
        sections = parse(path, package)
        if kind == "msg":
            return make_message(type_name, sections[0], self._resolve)
        if kind == "srv":
            return make_service(type_name, sections, self._resolve)
        return make_action(type_name, sections, self._resolve, self.load)

    def check(self, package: str) -> None:
        """Make every class of a package, so that a file that is not valid is found."""
        for kind in KINDS:
            for name in self.names(package, kind):
                self.load(f"{package}/{kind}/{name}")

    def _resolve(self, section: Section, field: Field) -> Any:
        package, name = field.type.base.split("/")
        where, wanted = f"{section.path}:{field.line}", f"{package}/msg/{name}"
        if wanted in self._making:
            circle = [*self._making[self._making.index(wanted) :], wanted]
            names = " contains ".join(one.rpartition("/")[2] for one in circle)
            raise InterfaceError(f"{where}: {names}: no message can")
        try:
            return self.load(wanted)
        except InterfaceError:
            raise
        except ImportError:
            raise InterfaceError(
                f"{where}: unknown type {package}/{name} of field {field.name!r}"
            ) from None

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        package, _, kind = fullname.partition(".")
        if kind and kind not in KINDS:
            return None  # Most imports end here, without a look at the disk.
        folders = self.folders(package)
        if kind:
            folders = [f for f in folders if (f / kind).is_dir()]
        if not folders:
            return None
        # A loader by its methods only, since importlib.abc takes long to import.
        origin, loader = str(folders[0]), cast(Any, self)
        return importlib.machinery.ModuleSpec(fullname, loader, origin=origin, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """Return None, so that Python makes an ordinary module."""

    def exec_module(self, module: ModuleType) -> None:
        package, _, kind = module.__name__.partition(".")
        if not kind:
            return
        names = self.names(package, kind)

        def __getattr__(name: str) -> Any:  # PEP 562: makes a class at its first use.
            if name not in names:
                raise AttributeError(f"{package} has no {kind} {name!r}")
            made = self.load(f"{package}/{kind}/{name}")
            setattr(module, name, made)
            return made

        module.__dict__.update(__getattr__=__getattr__, __all__=names)


def has_interfaces(folder: Path) -> bool:
    """Return True if a folder has msg/, srv/ or action/ in it."""
    # Checked first, because most folders that are asked for do not exist.
    return folder.is_dir() and any((folder / kind).is_dir() for kind in KINDS)
