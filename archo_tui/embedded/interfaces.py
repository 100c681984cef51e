"""Import hook: `from archo_interfaces.msg import BatteryStatus` reads `BatteryStatus.msg`.

A package is a folder with `msg/`, `srv/` or `action/` in it. Each file is looked for, in this
order, in the folders of the user's own, in those given by name, `share/` beside this file, and
`share/<package>/` of each prefix on AMENT_PREFIX_PATH: a package that is whole there completes one
that is partial here.
Classes are made at their first use.
"""

from __future__ import annotations

import contextlib
import importlib.machinery
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from .idl import Field, InterfaceError, Section, parse
from .messages import make_action, make_message, make_service

KINDS = ("msg", "srv", "action")


class InterfaceFinder:
    """Finds interface packages and is the loader of their modules."""

    def __init__(
        self, share: Path, packages: Mapping[str, Path], own: Mapping[str, Path] | None = None
    ) -> None:
        """`own` are the user's packages, whose files are taken before any other's."""
        self._share = share
        self._packages, self._own = dict(packages), dict(own or {})
        self._classes: dict[str, Any] = {}

    def folders(self, package: str) -> list[Path]:
        """The folders that hold the package's msg/, srv/ and action/, the first one first."""
        prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        candidates = [
            self._own.get(package),
            self._packages.get(package),
            self._share / package,
            *(Path(prefix) / "share" / package for prefix in prefixes if prefix),
        ]
        return [p for p in candidates if p is not None and any((p / k).is_dir() for k in KINDS)]

    def names(self, package: str, kind: str) -> list[str]:
        """The interfaces of one kind that a package defines."""
        found = (path.stem for f in self.folders(package) for path in f.glob(f"{kind}/*.{kind}"))
        return sorted(set(found))

    def load(self, type_name: str) -> Any:
        """The class of "package/kind/Name". Raises ImportError when there is none."""
        if type_name not in self._classes:
            package, kind, name = type_name.split("/")
            paths = [folder / kind / f"{name}.{kind}" for folder in self.folders(package)]
            path = next((path for path in paths if path.is_file()), None)
            if path is None:
                looked = ", ".join(map(str, paths)) or package
                raise ImportError(f"no interface {type_name}: looked for {looked}")
            sections = parse(path, package)
            if kind == "msg":
                made: Any = make_message(type_name, sections[0], self._resolve)
            elif kind == "srv":
                made = make_service(type_name, sections, self._resolve, self.load)
            else:
                made = make_action(type_name, sections, self._resolve, self.load)
            self._classes[type_name] = made
        return self._classes[type_name]

    def check(self) -> None:
        """Make every class of the user's packages. Raises InterfaceError with file and line."""
        for package in self._own:
            for kind in KINDS:
                for name in self.names(package, kind):
                    self.load(f"{package}/{kind}/{name}")

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
        if kind and kind not in KINDS:
            return None  # nearly all of what is imported: nothing is looked up for it
        folders = self.folders(package)
        if kind:
            folders = [f for f in folders if (f / kind).is_dir()]
        if not folders:
            return None
        # a loader by its methods: importlib.abc, for the type's sake, takes long to import
        origin, loader = str(folders[0]), cast(Any, self)
        return importlib.machinery.ModuleSpec(fullname, loader, origin=origin, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """None: an ordinary module."""

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


def packages_in(folder: Path) -> dict[str, Path]:
    """The interface packages of a folder by name: itself, or those of a workspace's `src/`."""
    places = [folder, *sorted(path.parent for path in folder.glob("**/package.xml"))]
    return {_name(p): p for p in places if any((p / kind).is_dir() for kind in KINDS)}


def _name(folder: Path) -> str:
    """What package.xml says, else the folder's own name."""
    from xml.etree import ElementTree  # slow to import, and needed for the user's packages only

    with contextlib.suppress(OSError, ElementTree.ParseError):
        found = ElementTree.parse(folder / "package.xml").findtext("name")
        if found and found.strip():
            return found.strip()
    return folder.resolve().name
