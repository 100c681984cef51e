"""Where the sockets of the consoles are. Imports nothing that takes time to load."""

from __future__ import annotations

import contextlib
import os
import socket
import stat
import sys
import time

SUFFIX = ".sock"
LONGEST = 107  # bytes of a socket's name that Linux takes
SOON = 1.0  # s in which a console that lives takes a connection, and says hello
_AGAIN = 0.01  # s


def folder() -> str:
    """`archo-tui` in XDG_RUNTIME_DIR, else beside the journal: never one that others can name."""
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    if os.path.isabs(runtime) and os.path.isdir(runtime):
        return os.path.join(runtime, "archo-tui")
    if sys.platform == "darwin":
        return os.path.expanduser("~/Library/Application Support/archo-tui/run")
    state = os.environ.get("XDG_STATE_HOME", "").strip() or os.path.expanduser("~/.local/state")
    return os.path.join(state, "archo-tui", "run")


def fault(path: str) -> str:
    """Why a folder is not one for sockets, or an empty string."""
    try:
        found = os.lstat(path)
    except OSError as error:
        return f"{path}: {error.strerror}"
    if not stat.S_ISDIR(found.st_mode):
        return f"{path} is not a folder"
    if hasattr(os, "getuid") and found.st_uid != os.getuid():
        return f"{path} belongs to somebody else"
    if found.st_mode & 0o077:
        return f"{path} is open to others: chmod 700 {path}"
    return ""


def sockets() -> list[str]:
    """The names of all that are there, of consoles that live or do not."""
    try:
        names = sorted(os.listdir(folder()))
    except OSError:
        return []
    return [name for name in names if name.endswith(SUFFIX)]


def reached(name: str) -> socket.socket | None:
    """A connection to that console; None, and its socket is removed, when nobody listens."""
    if sys.platform == "win32":
        return None
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    made.settimeout(SOON)
    held = -1
    try:
        held = os.open(folder(), os.O_RDONLY)
        _connect(made, short(held, name))
    except ConnectionRefusedError:  # of a console that was killed
        made.close()
        with contextlib.suppress(OSError):  # another one did it
            os.unlink(os.path.join(folder(), name))
        return None
    except OSError:  # it goes just now, or is too busy to take one
        made.close()
        return None
    finally:
        if held >= 0:
            os.close(held)
    return made


def _connect(made: socket.socket, name: str) -> None:
    """Raises OSError. Where too many wait to be taken Linux refuses at once."""
    end = time.monotonic() + SOON
    while True:
        try:
            return made.connect(name)
        except BlockingIOError:
            if time.monotonic() > end:
                raise
            time.sleep(_AGAIN)


def short(held: int, name: str) -> str:
    """The socket's name, through its folder's open descriptor where it would be too long.

    Raises OSError where there is no such way.
    """
    whole = os.path.join(folder(), name)
    if len(os.fsencode(whole)) <= LONGEST:
        return whole
    if not os.path.isdir("/proc/self/fd"):
        raise OSError(f"{whole} is too long for a socket's name")
    return f"/proc/self/fd/{held}/{name}"
