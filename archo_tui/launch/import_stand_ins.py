"""Stand-ins for packages that are not installed, found by `import` in place of any that are."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

ModuleContents = Mapping[str, Any]


class _Finder:
    """The import finder and loader of the stand-ins."""

    def __init__(
        self,
        families: Collection[str],
        contents: Callable[[str], ModuleContents | None],
        missing: Callable[[str, str], Any],
    ) -> None:
        self._families, self._contents, self._missing = families, contents, missing

    def is_of(self, module: str) -> bool:
        return module.partition(".")[0] in self._families

    def find_spec(self, name: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if not self.is_of(name) or self._contents(name) is None:
            return None
        loader: Any = self
        return ModuleSpec(name, loader, is_package=True)

    def create_module(self, spec: ModuleSpec) -> None:
        """Return None, so that Python makes an ordinary module."""

    def exec_module(self, module: ModuleType) -> None:
        def __getattr__(name: str) -> Any:  # PEP 562: what is not here, by its name.
            inside, found = f"{module.__name__}.{name}", None
            if name.islower() and not name.startswith("_") and self._contents(inside) is not None:
                return importlib.import_module(inside)
            if not name.startswith("_"):
                found = self._missing(module.__name__, name)
            if found is None:
                raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")
            setattr(module, name, found)
            return found

        module.__dict__.update(self._contents(module.__name__) or {}, __getattr__=__getattr__)


@contextmanager
def importable(
    families: Collection[str],
    contents: Callable[[str], ModuleContents | None],
    missing: Callable[[str, str], Any],
) -> Iterator[None]:
    """Let imports of some packages, inside this context, find what `contents` gives.

    `contents` gives the names of a module, None if there is no such module; `missing` makes any
    other name of a module, None if it has none.
    """
    finder: Any = _Finder(families, contents, missing)
    hidden = {name: sys.modules.pop(name) for name in [*filter(finder.is_of, sys.modules)]}
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name in [*filter(finder.is_of, sys.modules)]:
            del sys.modules[name]
        sys.modules.update(hidden)
