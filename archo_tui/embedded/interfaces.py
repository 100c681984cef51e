"""Import hook: `from archo_interfaces.msg import BatteryStatus` reads `BatteryStatus.msg`.

A package is a folder with `msg/`, `srv/` or `action/` in it. Looked for, in this order: the
folders given by name, `share/` beside this file, and `share/<package>/` of each prefix on
AMENT_PREFIX_PATH.
Classes are made at their first use.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from .idl import Field, InterfaceError, Section, parse
from .messages import make_action, make_message, make_service

KINDS = ("msg", "srv", "action")


class InterfaceFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds interface packages and is the loader of their modules."""

    def __init__(self, share: Path, packages: Mapping[str, Path]) -> None:
        self._share = share
        self._packages = dict(packages)
        self._classes: dict[str, Any] = {}

    def folder(self, package: str) -> Path | None:
        """The folder that holds the package's msg/, srv/ and action/, or None."""
        prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        candidates = [
            self._packages.get(package),
            self._share / package,
            *(Path(prefix) / "share" / package for prefix in prefixes if prefix),
        ]
        for path in candidates:
            if path is not None and any((path / kind).is_dir() for kind in KINDS):
                return path
        return None

    def names(self, package: str, kind: str) -> list[str]:
        """The interfaces of one kind that a package defines."""
        folder = self.folder(package)
        return sorted(path.stem for path in folder.glob(f"{kind}/*.{kind}")) if folder else []

    def load(self, type_name: str) -> Any:
        """The class of "package/kind/Name". Raises ImportError when there is none."""
        if type_name not in self._classes:
            package, kind, name = type_name.split("/")
            folder = self.folder(package)
            path = folder / kind / f"{name}.{kind}" if folder else None
            if path is None or not path.is_file():
                raise ImportError(f"no interface {type_name}: looked for {path or package}")
            sections = parse(path, package)
            if kind == "msg":
                made: Any = make_message(type_name, sections[0], self._resolve)
            elif kind == "srv":
                made = make_service(type_name, sections, self._resolve)
            else:
                made = make_action(type_name, sections, self._resolve, self.load)
            self._classes[type_name] = made
        return self._classes[type_name]

    def _resolve(self, section: Section, field: Field) -> Any:
        package, name = field.type.base.split("/")
        try:
            return self.load(f"{package}/msg/{name}")
        except InterfaceError:
            raise
        except ImportError:
            raise InterfaceError(
                f"{section.path}:{field.line}: unknown type {package}/{name} of field "
                f"{field.name!r}"
            ) from None

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        package, _, kind = fullname.partition(".")
        folder = self.folder(package)
        if folder is None or (kind and not (kind in KINDS and (folder / kind).is_dir())):
            return None
        return importlib.machinery.ModuleSpec(fullname, self, origin=str(folder), is_package=True)

    def exec_module(self, module: ModuleType) -> None:
        package, _, kind = module.__name__.partition(".")
        if not kind:
            return
        names = self.names(package, kind)

        def __getattr__(name: str) -> Any:  # PEP 562: makes the class when it is asked for
            if name not in names:
                raise AttributeError(f"{package} has no {kind} {name!r}")
            made = self.load(f"{package}/{kind}/{name}")
            setattr(module, name, made)
            return made

        module.__dict__.update(__getattr__=__getattr__, __all__=names)
