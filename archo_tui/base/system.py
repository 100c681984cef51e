"""The functions that differ between operating systems."""

from __future__ import annotations

import contextlib
import getpass
import os
import signal
import stat
import sys
from collections.abc import Sequence
from pathlib import Path

# The signals that ask the console to end; SIGHUP and SIGQUIT are POSIX's.
END_SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
    if hasattr(signal, name)
)
HANG_UP = 128 + int(getattr(signal, "SIGHUP", 1))  # The exit code after the terminal was lost.
CAN_SUSPEND = hasattr(signal, "SIGTSTP")


def user_name() -> str:
    """Return the name of this process's user, or its number, as in a container, or `unknown`."""
    with contextlib.suppress(KeyError, OSError, ImportError):  # ImportError on systems without pwd.
        return getpass.getuser()
    if sys.platform != "win32" and hasattr(os, "getuid"):
        return str(os.getuid())
    return "unknown"


def command_line(given: Sequence[str]) -> list[str]:
    """Return the command line that starts this program, from its zip file or by its module."""
    from zipfile import is_zipfile

    program = [sys.argv[0]] if is_zipfile(sys.argv[0]) else ["-m", "archo_tui"]
    return [sys.executable, *program, *given]


def is_suspended(child: int) -> bool:
    """Return True if a child process was stopped by a signal, and was not continued yet."""
    if sys.platform == "win32" or not hasattr(os, "waitid"):
        return False
    with contextlib.suppress(ChildProcessError):  # It has ended, and was waited for.
        kept = os.WSTOPPED | os.WNOHANG | os.WNOWAIT
        return os.waitid(os.P_PID, child, kept) is not None
    return False


def lock(descriptor: int) -> bool:
    """Lock a file until it is closed, without waiting; return False if another process holds it."""
    if sys.platform != "win32":
        with contextlib.suppress(ImportError):
            import fcntl

            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return False
    return True


def create_exclusively(path: Path) -> int:
    """Create a file, never following a link, and return its descriptor, to be closed."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
    return os.open(path, flags, 0o666)


def keep_owner_and_mode(descriptor: int, before: os.stat_result) -> None:
    """Give an open file the owner and the mode of another, on systems that have them."""
    if sys.platform != "win32" and hasattr(os, "fchown"):
        os.fchown(descriptor, before.st_uid, before.st_gid)
        os.fchmod(descriptor, stat.S_IMODE(before.st_mode))
