"""The names of the consoles' nodes, by which the consoles of a robot find each other."""

from __future__ import annotations

import itertools
import os
import re
import socket

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
    """Return the name of the console whose node this is: `anna_lab_4711`; "" for any other node.

    Args:
        node: The name of a node, with or without its namespace.
    """
    last = base_name(node)
    return last.removeprefix(PREFIX) if last.startswith(PREFIX) else ""
