"""The folders and files of the consoles' sockets. Imports nothing that takes time to load."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import stat
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

FOLDER_VARIABLE = "ARCHO_TUI_SOCKETS"  # Names a folder that is used in the place of all others.
SUFFIX = ".sock"
# The suffix of a card: the file beside the socket with the hello, read if the console is silent.
CARD_SUFFIX = ".json"
MAX_PATH = 107  # Bytes of a socket's path that Linux takes: unix(7), sun_path.
_RUNTIME = "/run/user"  # systemd makes a folder there for each user who is logged in.


def listening_folder() -> str:
    """Return the folder in which a console of this process listens; it may not exist yet.

    It is that of ARCHO_TUI_SOCKETS, else in XDG_RUNTIME_DIR if that is this user's, else in the
    state folder; "" if this user has no home either.
    """
    only, runtime = os.environ.get(FOLDER_VARIABLE, ""), os.environ.get("XDG_RUNTIME_DIR", "")
    if only:
        return os.path.abspath(only)
    if os.path.isabs(runtime) and os.path.isdir(runtime) and _owner(runtime) in (None, _uid()):
        return os.path.join(runtime, "archo-tui")
    return next(iter(_folders_in_homes()), "")


def all_folders() -> list[str]:
    """Return every folder in which a console of this user can listen, existing or not.

    Consoles started with other variables count: cron, `su -` and systemd set neither
    XDG_RUNTIME_DIR nor XDG_STATE_HOME. ARCHO_TUI_SOCKETS excludes all others.
    """
    if os.environ.get(FOLDER_VARIABLE, ""):
        return [listening_folder()]
    found = [listening_folder()]
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    if os.path.isabs(runtime):
        found.append(os.path.join(runtime, "archo-tui"))
    if _uid() is not None:
        found.append(os.path.join(_RUNTIME, str(_uid()), "archo-tui"))
    return [path for path in dict.fromkeys((*found, *_folders_in_homes())) if path]


def link_folder() -> str:
    """Return the folder in the home for links to the socket; "" if none is needed or possible.

    Clients with another XDG_RUNTIME_DIR find the console there.
    """
    own, last = listening_folder(), (_folders_in_homes() or [""])[-1]
    return "" if os.environ.get(FOLDER_VARIABLE, "") or last == own else last


def _folders_in_homes() -> list[str]:
    """Return the socket folders below XDG_STATE_HOME (not on macOS), HOME and the system's home.

    The last depends on no variable: `sudo` and `su` may leave another user's HOME behind.
    """
    state, homes = os.environ.get("XDG_STATE_HOME", "").strip(), [os.environ.get("HOME", "")]
    if sys.platform != "win32":
        import pwd

        with contextlib.suppress(KeyError):  # a user of a container that has no name
            homes.append(pwd.getpwuid(os.getuid()).pw_dir)
    homes = [home for home in homes if os.path.isabs(home)]
    if sys.platform == "darwin":
        return [f"{home}/Library/Application Support/archo-tui/run" for home in homes]
    states = [state] if os.path.isabs(state) else []
    states += [os.path.join(home, ".local/state") for home in homes]
    return [os.path.join(folder, "archo-tui", "run") for folder in states]


def _uid() -> int | None:
    return os.getuid() if hasattr(os, "getuid") else None


def _owner(path: str) -> int | None:
    return os.stat(path).st_uid if hasattr(os, "getuid") else None


def folder_fault(path: str) -> str:
    """Return why a folder is not used for sockets, as others could open it; "" if it is safe."""
    try:
        found = os.lstat(path)
    except OSError as error:
        return f"{path}: {error.strerror}"
    if not stat.S_ISDIR(found.st_mode):
        return f"{path} is not a folder"
    if found.st_uid != _uid() is not None:
        name = _user_name(found.st_uid)
        return f"{path} belongs to {name}: run this as {name}"
    if found.st_mode & 0o077:
        return f"{path} is open to others: chmod 700 {path}"
    return ""


def other_users() -> list[str]:
    """Return the names of other users whose sockets this user, mostly root, may list."""
    found = []
    if not os.environ.get(FOLDER_VARIABLE, ""):
        for user in _names_in(_RUNTIME):
            path = os.path.join(_RUNTIME, user, "archo-tui")
            if user.isdecimal() and int(user) != _uid() and any(map(_is_socket, _names_in(path))):
                found.append(_user_name(int(user)))
    return found


def _user_name(user: int) -> str:
    if sys.platform != "win32":
        import pwd

        with contextlib.suppress(KeyError):
            return pwd.getpwuid(user).pw_name
    return f"user {user}"


def _is_socket(name: str) -> bool:
    return name.endswith(SUFFIX) and name[0] != "."


def _names_in(path: str) -> list[str]:
    try:
        return sorted(os.listdir(path))
    except OSError:
        return []


def socket_paths(faults: list[str] | None = None) -> list[str]:
    """Return the paths of all sockets in all folders, also of dead consoles, each name once.

    The reason for each folder that is not searched, as others could listen there, is appended to
    `faults`.
    """
    found: dict[str, str] = {}  # by name: two paths may be one folder
    for path in all_folders():
        if not os.path.lexists(path):
            continue
        fault = folder_fault(path)
        if fault:
            if faults is not None:
                faults.append(fault)
            continue
        for name in filter(_is_socket, _names_in(path)):
            found.setdefault(name, os.path.join(path, name))
    return [*found.values()]


def read_card(path: str) -> dict[str, Any] | None:
    """Return the card of a socket: its console's hello in the file beside it; None without one."""
    try:
        with open(path.removesuffix(SUFFIX) + CARD_SUFFIX, "rb") as file:
            found = json.loads(file.read())
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def make_folder(path: str) -> None:
    """Make a folder for sockets with mode 0700; raise OSError if others could listen there."""
    parent = os.path.dirname(path)
    os.makedirs(os.path.dirname(parent), exist_ok=True)
    for folder in (parent, path):  # The state folder holds a journal, too.
        with contextlib.suppress(FileExistsError):
            os.mkdir(folder, 0o700)
    fault = folder_fault(path)
    if fault:
        raise OSError(fault)


def remove(path: str) -> None:
    """Remove a socket, its card, and the links to both; missing files are no error."""
    name = os.path.basename(path).removesuffix(SUFFIX)
    for folder in {os.path.dirname(path), *all_folders()}:
        for suffix in (SUFFIX, CARD_SUFFIX):
            with contextlib.suppress(OSError):  # there is none, or another one did it
                os.unlink(os.path.join(folder, name + suffix))


def connect(path: str) -> socket.socket:
    """Return a socket that is connected to `path` and does not block.

    Raises BlockingIOError if too many connections wait, ConnectionRefusedError or FileNotFoundError
    for a dead console, and other OSErrors.
    """
    if sys.platform == "win32":
        raise OSError("Windows has no such sockets")
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    descriptor = -1
    try:
        made.setblocking(False)
        descriptor = os.open(os.path.dirname(path), os.O_RDONLY)
        made.connect(short_path(descriptor, path))
    except BaseException:
        made.close()
        raise
    finally:
        if descriptor >= 0:
            os.close(descriptor)
    return made


def short_path(descriptor: int, path: str) -> str:
    """Return a path of at most 107 bytes to a socket, through its folder's descriptor if needed."""
    if len(os.fsencode(path)) <= MAX_PATH:
        return path
    if not os.path.isdir("/proc/self/fd"):
        raise OSError(f"{path} is too long for a socket's name")
    return f"/proc/self/fd/{descriptor}/{os.path.basename(path)}"
