"""Tracebacks for the person who wrote a node, without the frames of the engine."""

from __future__ import annotations

from pathlib import Path
from traceback import StackSummary, TracebackException
from types import ModuleType


def traceback_without(error: BaseException, *engine: ModuleType) -> str:
    """Return a traceback as text, without the frames of some packages.

    If frames are left out, a last line counts them. An error of the chain keeps its frames if all
    of them are within these packages.

    Args:
        error: The error.
        *engine: The packages.
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
    """Return a report, and the reports of the errors that led to it, by `from` or otherwise."""
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
