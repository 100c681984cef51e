"""The errors of a person's launch file or setup.py, in one line that says where."""

from __future__ import annotations

import linecache
import traceback
from collections.abc import Callable
from types import FrameType
from typing import Any, NamedTuple

from archo_tui.errors import first_line, quoted_line


class UserError(NamedTuple):
    """An error of a person's file."""

    file: str  # "" if no line is known.
    line: int  # From 1; 0 if none is known.
    text: str
    report: str  # The traceback, without the frames of the console; "" for code that hangs.


def describe(error: BaseException, is_own: Callable[[str], bool]) -> UserError:
    """Describe an error by the last line of a person's files in its traceback."""
    name, why = type(error).__name__, first_line(error)
    report = _own_traceback(error, is_own)
    if isinstance(error, SyntaxError) and is_own(error.filename or ""):
        text = f"SyntaxError: {error.msg}{quoted_line(error.text or '')}"
        return UserError(error.filename or "", error.lineno or 1, text, report)
    if isinstance(error, ModuleNotFoundError):
        why += " (looked for it where Python looks, and in the packages of the workspace)"
    if isinstance(error, SystemExit):
        why = f"it ends Python, exit code {error.code}"
    text = f"{name}: {why}".rstrip(": ")
    own = [f for f in traceback.extract_tb(error.__traceback__) if is_own(f.filename)]
    if not own:
        return UserError("", 0, text, report)
    return UserError(
        own[-1].filename, own[-1].lineno or 1, text + quoted_line(own[-1].line or ""), report
    )


def describe_hang(
    frame: FrameType | None, seconds: float, is_own: Callable[[str], bool]
) -> UserError:
    """Describe code of a person's file that does not return in time, by the line that runs."""
    while frame is not None and not is_own(frame.f_code.co_filename):
        frame = frame.f_back
    if frame is None:
        return UserError("", 0, f"does not return within {seconds:g} s", "")
    file, line = frame.f_code.co_filename, frame.f_lineno
    text = f"does not return within {seconds:g} s{quoted_line(linecache.getline(file, line))}"
    return UserError(file, line, text, "")


def _own_traceback(error: BaseException, is_own: Callable[[str], bool]) -> str:
    report: Any = traceback.TracebackException.from_exception(error)
    own = [frame for frame in report.stack if is_own(frame.filename)]
    report.stack = traceback.StackSummary.from_list(own)
    return "".join(report.format(chain=False))
