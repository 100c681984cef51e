"""Python code of a person's files, run in a process of its own that always ends.

The process answers one request with one value, or an error in one line that says where; what the
code prints is kept apart from it.
"""

from __future__ import annotations

import contextlib
import json
import linecache
import os
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable
from types import FrameType
from typing import IO, Any

from archo_tui.base.errors import ArchoError, first_line, quoted_line

_MAX_PRINTED = 100_000  # Bytes that are kept of what the code prints.
_MAX_ANSWER = 10_000_000  # Bytes; a launch file of a thousand nodes needs one million.
_GRACE = 2.0  # Seconds for Python's start, and for the process to say where it hangs.

IsOwn = Callable[[str], bool]  # Tells a person's files by their names.


class ChildError(ArchoError):
    """An error of a person's file."""

    def __init__(self, text: str, file: str = "", line: int = 0, report: str = "") -> None:
        """Create the error; the file is "" if no line is known.

        The report is the traceback without the frames of the console, or what the code printed.
        """
        super().__init__(text)
        self.file, self.line, self.report = file, line, report


def ask(module: str, request: Any, seconds: float) -> tuple[Any, str]:
    """Run `main()` of a module in a new process, send it a request, and return its answer.

    The second value is what the process has printed, its first 100 kB. The process, and what it has
    started, is killed after `seconds` and two more. Blocks: not for the UI thread. Raises
    ChildError.
    """
    given = json.dumps({"seconds": seconds, "request": request}).encode()
    answer, printed, exit_code = _run(module, given, seconds + _GRACE)
    try:
        answered = json.loads(answer)
    except ValueError:  # It ended within its answer, or before.
        how = f"it ended Python, exit code {exit_code}"
        if len(answer) == _MAX_ANSWER:
            how = f"its answer is over {_MAX_ANSWER / 1e6:g} MB"
        elif exit_code < 0:
            how = f"it does not return within {seconds:g} s"
        raise ChildError(how, report=printed) from None
    if "error" in answered:
        raise ChildError(**answered["error"])
    return answered["value"], printed


def _run(module: str, given: bytes, seconds: float) -> tuple[bytes, str, int]:
    """Run a module's `main()`, and return its answer, what it has printed, and its exit code."""
    # The path of this process, so that no file of the current folder is taken for a module.
    code = f"import sys; sys.path[:] = {sys.path!r}; from {module} import main; main()"
    pipes: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    command = [sys.executable, "-c", code]
    process: subprocess.Popen[bytes]
    try:
        process = subprocess.Popen(command, start_new_session=True, **pipes)
    except OSError as error:
        raise ArchoError(f"cannot start {sys.executable}: {error.strerror}") from None
    assert process.stdin
    assert process.stdout
    assert process.stderr
    answer, printed = bytearray(), bytearray()
    kept = (process.stdout, answer, _MAX_ANSWER), (process.stderr, printed, _MAX_PRINTED)
    readers = [threading.Thread(target=_read_all, args=each, daemon=True) for each in kept]
    for reader in readers:
        reader.start()
    try:
        with contextlib.suppress(OSError):  # It has ended already.
            process.stdin.write(given)
            process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
    finally:  # Also when the person presses Ctrl+C.
        _kill_group(process)
    for reader in readers:
        reader.join(_GRACE)
    return bytes(answer), bytes(printed).decode(errors="replace"), process.wait()


def _read_all(pipe: IO[bytes], kept: bytearray, limit: int) -> None:
    """Read a pipe to its end, and keep its first `limit` bytes."""
    with pipe, contextlib.suppress(OSError, ValueError):
        while chunk := os.read(pipe.fileno(), 65_536):
            kept += chunk[: limit - len(kept)]


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    if sys.platform == "win32":
        process.kill()
    else:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)


def serve(answer: Callable[[Any], Any], is_own: IsOwn) -> None:
    """Answer the request of `ask`, and end the process: this function does not return.

    What the code prints goes to standard error. If time is over, the answer is the line of a
    person's file that runs then.
    """
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # What the code prints goes to standard error.
    sys.dont_write_bytecode = True  # No __pycache__ appears in the user's folders.
    given = json.loads(sys.stdin.buffer.read())
    lock, main_thread = threading.Lock(), threading.get_ident()

    def end(**answered: Any) -> None:
        with lock:
            with contextlib.suppress(OSError):  # Who asked was killed.
                output.write(json.dumps(answered).encode() + b"\n")
                output.flush()
            with contextlib.suppress(Exception):
                sys.stdout.flush()
                sys.stderr.flush()
            os._exit(0)

    def end_late() -> None:
        frame = sys._current_frames().get(main_thread)
        end(error=_as_json(_hang(frame, given["seconds"], is_own)))

    watchdog = threading.Timer(given["seconds"], end_late)
    watchdog.daemon = True
    watchdog.start()
    try:
        value = answer(given["request"])
    except BaseException as error:
        found = error if isinstance(error, ChildError) else described(error, is_own)
        end(error=_as_json(found))
    end(value=value)


def _as_json(error: ChildError) -> dict[str, Any]:
    return {"text": str(error), **vars(error)}


def described(error: BaseException, is_own: IsOwn) -> ChildError:
    """Describe an error by the last line of a person's files in its traceback."""
    name, why = type(error).__name__, first_line(error)
    report: Any = traceback.TracebackException.from_exception(error)
    own = [frame for frame in report.stack if is_own(frame.filename)]
    report.stack = traceback.StackSummary.from_list(own)
    lines = "".join(report.format(chain=False))
    if isinstance(error, SyntaxError) and is_own(error.filename or ""):
        text = f"SyntaxError: {error.msg}{quoted_line(error.text or '')}"
        return ChildError(text, error.filename or "", error.lineno or 1, lines)
    if isinstance(error, ModuleNotFoundError):
        why += " (looked for it where Python looks, and in the packages of the workspace)"
    if isinstance(error, SystemExit):
        why = f"it ends Python, exit code {error.code}"
    text = f"{name}: {why}".rstrip(": ")
    if not own:
        return ChildError(text, report=lines)
    last = own[-1]
    return ChildError(text + quoted_line(last.line or ""), last.filename, last.lineno or 1, lines)


def _hang(frame: FrameType | None, seconds: float, is_own: IsOwn) -> ChildError:
    """Describe code of a person's file that does not return in time, by the line that runs."""
    text = f"does not return within {seconds:g} s"
    while frame is not None and not is_own(frame.f_code.co_filename):
        frame = frame.f_back
    if frame is None:
        return ChildError(text)
    file, line = frame.f_code.co_filename, frame.f_lineno
    return ChildError(text + quoted_line(linecache.getline(file, line)), file, line)
