"""Which signals `rclpy.init` would handle. The embedded engine takes none away from the program."""

from enum import IntEnum


class SignalHandlerOptions(IntEnum):
    """As in rclpy; every value means NO here: Ctrl-C raises KeyboardInterrupt."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3
