"""The folder of the consoles' sockets, each with its card: a JSON file that holds its hello.

The folder depends on no variable, so that cron, `su` and an assistant's program find the same. As
tmux's, it is in /tmp: /run/user/UID goes with the last login, and a console in tmux lives on.
"""

from __future__ import annotations

import contextlib
import json
import os
import stat
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

FOLDER_VARIABLE = "ARCHO_TUI_SOCKETS"  # Names a folder that is used in place of the usual one.
SUFFIX, CARD_SUFFIX = ".sock", ".json"
_TEMPORARY, _PREFIX = "/tmp", "archo-tui-"  # Followed by the number of the user.


def folder() -> str:
    """Return the folder of this user's sockets, which may not exist yet; "" on Windows."""
    only = os.environ.get(FOLDER_VARIABLE, "")
    if only or sys.platform == "win32":
        return os.path.abspath(only) if only else ""
    return f"{_TEMPORARY}/{_PREFIX}{uid()}"


def uid() -> int:
    """Return the number of this user; 0 where users have none, as on Windows."""
    if sys.platform == "win32" or not hasattr(os, "getuid"):
        return 0
    return os.getuid()


def folder_fault(path: str) -> str:
    """Return why a folder is not used for sockets, as others could open it; "" if it is safe."""
    try:
        found = os.lstat(path)
    except OSError as error:
        return f"{path}: {error.strerror}"
    if not stat.S_ISDIR(found.st_mode):
        return f"{path} is not a folder"
    if found.st_uid != uid():
        name = _user_name(found.st_uid)
        return f"{path} belongs to {name}: run this as {name}"
    return f"{path} is open to others: chmod 700 {path}" if found.st_mode & 0o077 else ""


def socket_paths(faults: list[str] | None = None) -> list[str]:
    """Return the paths of this user's sockets, also of dead consoles.

    The reason why the folder is not searched, as others could listen there, goes into `faults`.
    """
    path = folder()
    if not path or not os.path.lexists(path):
        return []
    fault = folder_fault(path)
    if fault and faults is not None:
        faults.append(fault)
    return [] if fault else [os.path.join(path, name) for name in _sockets_in(path)]


def other_users() -> list[str]:
    """Return the names of other users whose sockets this user, mostly root, may list."""
    if os.environ.get(FOLDER_VARIABLE, ""):
        return []
    users = [name.removeprefix(_PREFIX) for name in _names_in(_TEMPORARY) if _PREFIX in name]
    return [
        _user_name(int(user))
        for user in users
        if user.isdecimal() and int(user) != uid() and _sockets_in(f"{_TEMPORARY}/{_PREFIX}{user}")
    ]


def _user_name(user: int) -> str:
    if sys.platform != "win32":
        import pwd

        with contextlib.suppress(KeyError):  # A user of a container that has no name.
            return pwd.getpwuid(user).pw_name
    return f"user {user}"


def _sockets_in(path: str) -> list[str]:
    return [name for name in _names_in(path) if name.endswith(SUFFIX)]


def _names_in(path: str) -> list[str]:
    try:
        return sorted(os.listdir(path))
    except OSError:
        return []


def card_path(path: str) -> str:
    """Return the path of the card of a socket."""
    return path.removesuffix(SUFFIX) + CARD_SUFFIX


def read_card(path: str) -> dict[str, Any]:
    """Return the card of a socket; empty if there is none, or it does not name its console."""
    try:
        with open(card_path(path), "rb") as file:
            card = json.loads(file.read())
    except (OSError, ValueError, RecursionError):
        return {}
    texts = "robot", "namespace", "engine", "name"
    is_named = isinstance(card, dict) and type(card.get("pid")) is int
    return card if is_named and all(isinstance(card.get(text), str) for text in texts) else {}


def remove(path: str) -> None:
    """Remove a socket and its card; missing files are no error."""
    for name in (path, card_path(path)):
        with contextlib.suppress(OSError):  # There is none, or another one did it.
            os.unlink(name)
