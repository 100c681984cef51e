"""The errors of a user's file in words that say what to mend, and where."""

from __future__ import annotations

import contextlib
import traceback
from types import CodeType
from typing import Any

import rclpy

import archo_tui
from archo_tui.errors import first_line, quoted_line
from archo_tui.hosting.own_code import OwnCode
from archo_tui.hosting.source import Source
from archo_tui.hosting.tracebacks import traceback_without

# Errors that rclpy raises without a text, and what they mean.
WORDLESS = {"TypeError": "TypeError: a message of another type is expected here"}
# The texts of rcl for a topic that has another type in this process already, as Fast DDS refuses.
# The second text is a subscription's, whose own reason rcl overwrites.
_TWO_TYPES = ("with incompatible type", "Failed to create subscription: invalid allocator")
_ONE_TYPE = "another node of this process has the topic with another type, and Fast DDS allows one"
_INTERFACE_SUFFIXES = ("_msgs", "_srvs", "_interfaces")  # Of the names of interface packages.
_NOT_CALLED = "give the callback itself: self.name, not self.name()"


def explain(error: BaseException, own_code: OwnCode, source: Source) -> tuple[str, str]:
    """Describe an error of a file's code for the person who wrote it.

    Args:
        error: The error.
        own_code: The code of the file and of its folder.
        source: The text of the file.

    Returns:
        A line, as `FILE:LINE: TypeError: ..., in: x = y + 1`, which for known mistakes says how to
        mend them; and the traceback without the frames of rclpy and the console. The place is that
        of a syntax error, else the last line that ran of the file or its modules, else a callback
        that the error is about; else FILE without a line.
    """
    name, why = type(error).__name__, reason_of(error)
    report = traceback_without(error, rclpy, archo_tui)
    if isinstance(error, SyntaxError) and own_code.is_own(error.filename or ""):
        place = f"{own_code.display_name(error.filename or '')}:{error.lineno}"
        return f"{place}: {name}: {error.msg}{quoted_line(error.text or '')}", report
    if isinstance(error, ModuleNotFoundError):
        why += f" (looked for it in {own_code.path.parent} and where Python looks)"
        if (error.name or "").partition(".")[0].endswith(_INTERFACE_SUFFIXES):
            why += ": --interfaces DIR takes the package with its .msg files"
    if "must only be called once" in why:
        why = "rclpy.init() runs here already: call it in main() only"
    stack = traceback.extract_tb(error.__traceback__)
    where, line = own_code.place(stack)
    if line:
        why = _in_plain_words(own_code, source, where, why)
    else:
        where, why = _place_of_callback(error, own_code, source, where, why)
    text = f"{name}: {why}".rstrip(": ")
    return f"{where}: {WORDLESS.get(text, text)}{line}", report


def reason_of(error: BaseException) -> str:
    """Return the first line of an error's text; "" if there is none, or its `__str__` raises.

    The text about a topic that has two types in this process, which Fast DDS reports as an
    incompatible type or an invalid allocator, is replaced by an explanation.
    """
    text = ""
    with contextlib.suppress(Exception):  # A __str__ of the user's own may fail, too.
        text = first_line(error)
    if any(sign in text for sign in _TWO_TYPES):
        return f"{text.partition(':')[0]}: {_ONE_TYPE}"
    return text


def _in_plain_words(own_code: OwnCode, source: Source, where: str, why: str) -> str:
    """Return how to mend a wrong call of rclpy, or `why` if it is none of the known mistakes.

    Args:
        own_code: The code of the file and of its folder.
        source: The text of the file.
        where: `FILE:LINE` of the last line that ran of the file or its modules.
        why: The text of the error.
    """
    early = source.line_of_called_callback()
    if "callback" in why and where == f"{own_code}:{early}":
        return _NOT_CALLED
    if "_TYPE_SUPPORT" in why or "resolve_name(): incompatible" in why:
        return "the type comes first, then the name, as in Float32, 'battery_level'"
    if "__init__() takes 1 positional argument but" in why:
        return f"{why}: name the fields, as in Float32(data=87.5)"
    return why


def _place_of_callback(
    error: BaseException, own_code: OwnCode, source: Source, where: str, why: str
) -> tuple[str, str]:
    """Find the callback of the file or its modules that an error within rclpy is about.

    Args:
        error: The error, which has no frame of the file.
        own_code: The code of the file and of its folder.
        source: The text of the file.
        where: The place so far.
        why: The text so far.

    Returns:
        `FILE:LINE` of the callback, and how to mend it, or `why` if that is not known; `where` and
        `why` if there is no such callback.
    """
    # A timer whose callback is None raises UnboundLocalError in rclpy's own code.
    if isinstance(error, UnboundLocalError) or "'NoneType' object is not callable" in why:
        line = source.line_of_called_callback()
        if line is not None:
            return f"{own_code}:{line}", _NOT_CALLED
    for frame, _ in reversed([*traceback.walk_tb(error.__traceback__)]):
        for value in frame.f_locals.values():
            code = code_of(value)
            if code is not None and own_code.is_own(code.co_filename):
                named, line = own_code.display_name(code.co_filename), code.co_firstlineno
                lacks = named == str(own_code) and source.missing_return(line)
                if lacks:
                    why = f"{code.co_name} returns nothing: end it with return {lacks}"
                elif isinstance(error, TypeError) and code.co_varnames[:1] != ("self",):
                    why += ": its first parameter must be self" if _is_method(value) else ""
                return f"{named}:{line}", why
    return where, why


def code_of(value: Any) -> CodeType | None:
    """Return the code of a callback, or of the callback of a timer or service; else None."""
    with contextlib.suppress(Exception):  # A property of the user's may raise anything.
        callback = getattr(value, "callback", value)
        code = getattr(getattr(callback, "__func__", callback), "__code__", None)
        return code if isinstance(code, CodeType) else None
    return None


def _is_method(value: Any) -> bool:
    return hasattr(getattr(value, "callback", value), "__self__")
