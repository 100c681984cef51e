"""Who else operates this robot: each console's node has a name of its own, hidden as tools' are."""

from __future__ import annotations

import itertools
import os
import re
import socket

from archo_tui.system import user_name

PREFIX = "_archo_console_"
_LONGEST = 200  # characters; rclpy takes 255
_numbers = itertools.count(1)


def own_name() -> str:
    """`_archo_console_anna_lab_4711`; of a second one in this process with its number behind."""
    number = next(_numbers)
    more = f"_{number}" if number > 1 else ""
    name = f"{PREFIX}{user_name()}_{socket.gethostname()}_{os.getpid()}{more}"
    return re.sub(r"_*[^A-Za-z0-9_]+_*", "_", name)[:_LONGEST]


def author(node: str) -> str:
    """Who a console's node is, without the namespace and what they all begin with; else empty."""
    last = node.rpartition("/")[2]
    return last.removeprefix(PREFIX) if last.startswith(PREFIX) else ""
