"""The names of the consoles' nodes, by which the consoles of a robot find each other."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import socket
from collections import Counter
from collections.abc import Collection

from archo_tui.ros_names import base_name
from archo_tui.system import user_name

PREFIX = "_archo_console_"
_LONGEST = 200  # Characters; rclpy accepts 255.
_numbers = itertools.count(1)


def new_node_name() -> str:
    """Return a new name for a console's node: `_archo_console_anna_lab_4711` (user, host, process).

    The second name in one process ends with `_2`, and so on. Other characters than letters, digits
    and `_` become `_`; at most 200 characters are kept.
    """
    number = next(_numbers)
    more = f"_{number}" if number > 1 else ""
    name = f"{PREFIX}{user_name()}_{socket.gethostname()}_{os.getpid()}{more}"
    return re.sub(r"_*[^A-Za-z0-9_]+_*", "_", name)[:_LONGEST]


def author(node: str) -> str:
    """Return the name of the console whose node this is: `anna_lab_4711`; "" for any other node."""
    last = base_name(node)
    return last.removeprefix(PREFIX) if last.startswith(PREFIX) else ""


def new_goal_id(console: str) -> bytes:
    """Return the 16 bytes of a new goal's UUID, by which other consoles know whose goal it is."""
    return _mark(console) + os.urandom(8)


def _mark(console: str) -> bytes:
    """Return the first half of the ids of a console's goals."""
    return hashlib.blake2b(console.encode(), digest_size=8).digest()


def goals_of_others(ids: Collection[bytes], consoles: Collection[str]) -> str:
    """Return `cancelling 2 goals of console anna_lab_4711, 9 goals of other clients`."""
    by_mark = {_mark(console): f"console {console}" for console in sorted(consoles)}
    counts = Counter(by_mark.get(goal_id[:8], "") for goal_id in ids)
    unknown = counts.pop("", 0)
    parts = [f"{_goals(count)} of {console}" for console, count in sorted(counts.items())]
    if unknown:
        clients = "another client" if unknown == 1 else "other clients"
        parts.append(f"{_goals(unknown)} of {clients}")
    return f"cancelling {', '.join(parts)}" if parts else "no goal of another client was cancelled"


def _goals(count: int) -> str:
    return "1 goal" if count == 1 else f"{count} goals"
