"""Nodes from Python files of the user's own: `--node FILE`."""

from __future__ import annotations

import importlib.util
import inspect
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any

from rclpy.context import Context
from rclpy.node import Node

from archo_tui.errors import ArchoError


class FileNode:
    """Makes one node of a class that a file defines, as `main()` of the file would."""

    def __init__(self, path: Path, kind: type[Node]) -> None:
        self._path, self._kind = path, kind

    def __call__(self, context: Context, **options: Any) -> Node:
        """Raises ArchoError that names file and line for whatever the constructor raises.

        A textbook's constructor takes nothing: its node is made in the default context.
        """
        known = inspect.signature(self._kind).parameters
        takes_all = any(p.kind == p.VAR_KEYWORD for p in known.values())
        given = {"context": context, **options}
        if not takes_all:
            if options.keys() - known.keys():
                raise ArchoError(
                    f"{self._path}: {self._kind.__name__} takes no {', '.join(options)}, "
                    "so a copy would have the same name"
                )
            given = {name: value for name, value in given.items() if name in known}
        try:
            return self._kind(**given)
        except Exception as error:
            raise ArchoError(_said(self._path, error)) from error


def load(path: Path) -> list[FileNode]:
    """The nodes that a file defines. Raises ArchoError with one line that says what is wrong."""
    module = _run(path)
    kinds = [
        kind
        for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, Node) and kind.__module__ == module.__name__
    ]
    nodes = [kind for kind in kinds if not any(kind in other.__mro__[1:] for other in kinds)]
    if not nodes:
        raise ArchoError(f"{path}: defines no subclass of rclpy.node.Node")
    return [FileNode(path, kind) for kind in dict.fromkeys(nodes)]


def _run(path: Path) -> ModuleType:
    if not path.is_file():
        raise ArchoError(f"{path}: no such file")
    name = f"_node_file_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ArchoError(f"{path}: not a Python file")
    module = importlib.util.module_from_spec(spec)
    folder = str(path.resolve().parent)  # what stands beside it can be imported, as by `python`
    if folder not in sys.path:
        sys.path.insert(0, folder)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise ArchoError(_said(path, error)) from None
    return module


def _said(path: Path, error: BaseException) -> str:
    """`FILE:LINE: TypeError: ...`, by the last line of the file itself that was running."""
    if isinstance(error, SyntaxError) and _is(path, error.filename or ""):
        return f"{path}:{error.lineno}: {type(error).__name__}: {error.msg}"
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if _is(path, frame.filename)]
    where = f"{path}:{lines[-1]}" if lines else str(path)
    said = (str(error).splitlines() or [""])[0]
    if "must only be called once" in said:
        said = "rclpy.init() runs when the file is imported: call it in main()"
    return f"{where}: {type(error).__name__}: {said}"


def _is(path: Path, filename: str) -> bool:
    return Path(filename).resolve() == path.resolve()
