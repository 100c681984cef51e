"""Python code of a person's files, run in a process of its own that always ends.

The process answers one request with one value; what the code prints is kept apart from it.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import IO, Any, NamedTuple

from archo_tui.errors import ArchoError

_MAX_PRINTED = 100_000  # Bytes that are kept of what the code prints.
_MAX_ANSWER = 10_000_000  # Bytes; a launch file of a thousand nodes needs one million.
_GRACE = 2.0  # Seconds for Python's start, and for the process to say where it hangs.


class Reply(NamedTuple):
    """The outcome of a request."""

    value: Any  # As JSON has it; None if the process ended without a whole answer.
    printed: str  # The first 100 kB.
    exit_code: int  # Negative for a signal, such as the kill when its time was over.


def ask(module: str, request: Any, seconds: float) -> Reply:
    """Run `main()` of a module in a new process, send it a request, and return its reply.

    The process, and what it has started, is killed after `seconds` and two more. Blocks: not for
    the UI thread.
    """
    # The path of this process, so that no file of the current folder is taken for a module.
    code = f"import sys; sys.path[:] = {sys.path!r}; from {module} import main; main()"
    pipe = subprocess.PIPE
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            start_new_session=True,
        )
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
            process.stdin.write(json.dumps({"seconds": seconds, "request": request}).encode())
            process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds + _GRACE)
    finally:  # Also when the person presses Ctrl+C.
        _kill_group(process)
    for reader in readers:
        reader.join(_GRACE)
    if len(answer) > _MAX_ANSWER:
        raise ArchoError(f"the answer of {module} is larger than {_MAX_ANSWER // 1_000_000} MB")
    value = None
    with contextlib.suppress(ValueError):  # It ended within its answer, or before.
        value = json.loads(bytes(answer))
    return Reply(value, bytes(printed).decode(errors="replace"), process.wait())


def _read_all(pipe: IO[bytes], kept: bytearray, limit: int) -> None:
    """Read a pipe to its end, and keep its first `limit` bytes, and one more if there is."""
    with pipe, contextlib.suppress(OSError, ValueError):
        while chunk := os.read(pipe.fileno(), 65_536):
            kept += chunk[: limit + 1 - len(kept)]


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    if sys.platform == "win32":
        process.kill()
    else:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)


def serve(answer: Callable[[Any], Any], late: Callable[[FrameType | None, float], Any]) -> None:
    """Answer the request of `ask`, and end the process: this function does not return.

    What the code prints goes to standard error. If time is over, `late` is called on another
    thread, with the frame that runs in the main thread.
    """
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # What the code prints goes to standard error.
    sys.dont_write_bytecode = True  # No __pycache__ appears in the user's folders.
    given = json.loads(sys.stdin.buffer.read())
    lock, main_thread = threading.Lock(), threading.get_ident()

    def end(value: Any) -> None:
        with lock:
            output.write(json.dumps(value).encode() + b"\n")
            output.flush()
            with contextlib.suppress(Exception):
                sys.stdout.flush()
                sys.stderr.flush()
            os._exit(0)

    def end_late() -> None:
        end(late(sys._current_frames().get(main_thread), given["seconds"]))

    watchdog = threading.Timer(given["seconds"], end_late)
    watchdog.daemon = True
    watchdog.start()
    end(answer(given["request"]))
