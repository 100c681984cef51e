"""The errors of a user's file in words that say what to mend, and where."""

from __future__ import annotations

import contextlib
import re
import sys
import sysconfig
import traceback
from functools import cache
from pathlib import Path
from traceback import StackSummary, TracebackException
from types import CodeType, ModuleType
from typing import Any

import rclpy
from rclpy.node import Node

import archo_tui
from archo_tui.base.errors import UserFileError, first_line, quoted_line
from archo_tui.base.nearest import nearest_hint
from archo_tui.user_code.source import Source

# Errors that rclpy raises without a text, and what they mean.
WORDLESS = {"TypeError": "TypeError: a message of another type is expected here"}
# The texts of rcl for a topic that has another type in this process already, as Fast DDS refuses.
# The second text is a subscription's, whose own reason rcl overwrites.
_TWO_TYPES = ("with incompatible type", "Failed to create subscription: invalid allocator")
_ONE_TYPE = "another node of this process has the topic with another type, and Fast DDS allows one"
_INTERFACE_SUFFIXES = ("_msgs", "_srvs", "_interfaces")  # Of the names of interface packages.
_NO_CONTEXT = ("InvalidHandle", "RCLError")
_SHUT_DOWN = "rclpy.shutdown() ends the node that calls it: call it at the end of main() only"
_NOT_CALLED = "give the callback itself: self.name, not self.name()"
# Python itself may be in the home folder, beside the user's files.
_PYTHON = Path(sysconfig.get_path("stdlib")).resolve()
_CONSOLE = Path(archo_tui.__file__).resolve().parent  # In a clone, beside the user's files.


class NodeFileError(UserFileError):
    """The error for a user's file that cannot be found or run."""


@cache  # A start asks about all imported modules, and each question takes a look at the disk.
def _resolved(filename: str) -> tuple[Path, bool]:
    """Return where a file of code is, and True if it belongs to Python or to what is installed."""
    path = Path(filename).resolve()
    is_installed = "site-packages" in path.parts
    return path, is_installed or not {_PYTHON, _CONSOLE}.isdisjoint(path.parents)


class OwnCode:
    """The code of a file and of its folder."""

    def __init__(self, given: str, path: Path) -> None:
        self._given, self.path = given, path
        self._known: dict[str, bool] = {}

    def __str__(self) -> str:
        return self._given

    def is_own(self, filename: str) -> bool:
        """Return True for the file itself, and files in or below its folder, unless installed.

        Python's own library, the console and `site-packages` count as installed.
        """
        if not filename:  # Built-in code has none.
            return False
        if filename not in self._known:
            path, is_installed = _resolved(filename)
            is_beside = not is_installed and self.path.parent in path.parents
            self._known[filename] = path == self.path or is_beside
        return self._known[filename]

    def display_name(self, filename: str) -> str:
        """Return the name of a file for people: of this file as typed, of others without folder."""
        path = Path(filename).resolve()
        return self._given if path == self.path else path.name

    def place(self, stack: StackSummary) -> tuple[str, str]:
        """Return `FILE:LINE` and `, in: TEXT` of the last own frame of a stack; else FILE, ""."""
        frames = [frame for frame in stack if self.is_own(frame.filename)]
        if not frames:
            return self._given, ""
        last = frames[-1]
        return f"{self.display_name(last.filename)}:{last.lineno}", quoted_line(last.line or "")


def explain(error: BaseException, own_code: OwnCode, source: Source) -> tuple[str, str]:
    """Return an error in one line with its place, and how to mend it, and the traceback."""
    name, why = type(error).__name__, reason_of(error)
    report = traceback_without(error, rclpy, archo_tui)
    if isinstance(error, SyntaxError) and own_code.is_own(error.filename or ""):
        place = own_code.display_name(error.filename or "")
        place += f":{error.lineno}" if error.lineno else ""  # 0 for an unknown encoding.
        return f"{place}: {name}: {error.msg}{quoted_line(error.text or '')}", report
    interface = _missing_interface(error)
    if isinstance(error, ModuleNotFoundError):
        why += f" (looked for it in {own_code.path.parent} and where Python looks)"
    stack = traceback.extract_tb(error.__traceback__)
    where, line = own_code.place(stack)
    unmade = _unmade_node(error) if not own_code.is_own(stack[-1].filename if stack else "") else ""
    if unmade:
        return str(missing_super_error(unmade, own_code, source)), report
    if line and not _only_spins(stack, own_code):
        why = _in_plain_words(own_code, source, where, why)
    else:
        found, reason = _place_of_callback(error, own_code, source, str(own_code), why)
        if found != str(own_code):
            where, line, why = found, "", reason
    text = interface or f"{name}: {why}".rstrip(": ")
    return f"{where}: {WORDLESS.get(text, text)}{line}", report


def _missing_interface(error: BaseException) -> str:
    """Return which package of interfaces, or which interface of one, cannot be imported, or ""."""
    if not isinstance(error, ImportError):  # Of any other, the text may raise.
        return ""
    module = error.name or ""
    package, _, kind = module.partition(".")
    if isinstance(error, ModuleNotFoundError):
        is_interface = package.endswith(_INTERFACE_SUFFIXES)
        how = "--interfaces DIR takes it with its .msg files"
        return f"no package {package}: {how}" if is_interface else ""
    wanted = re.match(r"cannot import name '(\w+)'", str(error))
    if wanted is None or kind not in ("msg", "srv", "action"):
        return ""
    near = nearest_hint(wanted[1], [name for name in vars(sys.modules[module]) if name[0] != "_"])
    return f"no {kind} {wanted[1]} in {package}{near}"


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
    """Return how to mend a wrong call of rclpy, or `why` if it is none of the known mistakes."""
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
    """Return `FILE:LINE` of the callback that an error in rclpy is about, and how to mend it."""
    # A timer whose callback is None raises UnboundLocalError in rclpy's own code.
    if isinstance(error, UnboundLocalError) or "'NoneType' object is not callable" in why:
        line = source.line_of_called_callback()
        if line is not None:
            return f"{own_code}:{line}", _NOT_CALLED
    shut = source.line_of_call("shutdown") if type(error).__name__ in _NO_CONTEXT else None
    if shut is not None:
        return f"{own_code}:{shut}", _SHUT_DOWN
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


def _only_spins(stack: StackSummary, own_code: OwnCode) -> bool:
    """Return True if the last line of the file or its modules spins, and so did nothing wrong."""
    own = [number for number, frame in enumerate(stack) if own_code.is_own(frame.filename)]
    return any(frame.name.startswith("spin") for frame in stack[own[-1] + 1 :][:1])


def is_made(node: Node) -> bool:
    """Return True if rclpy's own `Node.__init__` has run."""
    try:
        node.get_name()
    except AttributeError:
        return False
    return True


def missing_super_error(class_name: str, own_code: OwnCode, source: Source) -> NodeFileError:
    """Return the error for a class that does not call the `__init__` of Node."""
    line, what = source.missing_super_init(class_name)
    return NodeFileError(f"{own_code}:{line}: {what}")


def _unmade_node(error: BaseException) -> str:
    """Return the class of the node that rclpy failed with, as its `__init__` never ran, or ""."""
    if isinstance(error, AttributeError):
        for frame, _ in traceback.walk_tb(error.__traceback__):
            for value in frame.f_locals.values():
                if isinstance(value, Node) and not is_made(value):
                    return type(value).__name__
    return ""


def code_of(value: Any) -> CodeType | None:
    """Return the code of a callback, or of the callback of a timer or service; else None."""
    with contextlib.suppress(Exception):  # A property of the user's may raise anything.
        callback = getattr(value, "callback", value)
        code = getattr(getattr(callback, "__func__", callback), "__code__", None)
        return code if isinstance(code, CodeType) else None
    return None


def _is_method(value: Any) -> bool:
    return hasattr(getattr(value, "callback", value), "__self__")


def traceback_without(error: BaseException, *engine: ModuleType) -> str:
    """Return a traceback as text without the frames of some packages, which a last line counts."""
    folders = {Path(module.__file__ or "").parent for module in engine}
    report = TracebackException.from_exception(error)
    left_out, waiting = 0, [report]
    while waiting:  # As many as a recursion is deep may have led to each other.
        part = waiting.pop()
        left_out += _leave_out(part, folders)
        waiting += filter(None, (part.__cause__, part.__context__))
    text = "".join(report.format())
    return f"{text}({left_out} frames of the engine are left out)\n" if left_out else text


def _leave_out(report: TracebackException, folders: set[Path]) -> int:
    """Take the frames of folders from a report, unless it has no other; return how many."""
    kept = [frame for frame in report.stack if folders.isdisjoint(Path(frame.filename).parents)]
    count = len(report.stack) - len(kept) if kept else 0
    if count:
        report.stack = StackSummary.from_list(kept)
    return count
