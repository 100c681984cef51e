"""A traceback for the person who wrote the node: its own frames, the engine's only counted."""

from __future__ import annotations

from pathlib import Path
from traceback import StackSummary, TracebackException
from types import ModuleType


def own_frames(error: BaseException, *engine: ModuleType) -> str:
    """The traceback of `error` without the frames in the folders of those packages.

    The frames that are left out are counted in the last line. An error that never left the engine
    is shown whole.
    """
    folders = [Path(module.__file__ or "").parent for module in engine]
    report = TracebackException.from_exception(error)
    left_out = 0
    for part in _chain(report):
        kept = [frame for frame in part.stack if not _within(frame.filename, folders)]
        if kept:
            left_out += len(part.stack) - len(kept)
            part.stack = StackSummary.from_list(kept)
    text = "".join(report.format())
    return f"{text}({left_out} frames of the engine are left out)\n" if left_out else text


def _chain(report: TracebackException) -> list[TracebackException]:
    """The error and those that led to it."""
    found: list[TracebackException] = []
    waiting: list[TracebackException | None] = [report]
    while waiting:
        part = waiting.pop()
        if part is not None and part not in found:
            found.append(part)
            waiting += [part.__cause__, part.__context__]
    return found


def _within(filename: str, folders: list[Path]) -> bool:
    return any(folder in Path(filename).parents for folder in folders)
