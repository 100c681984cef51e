"""The signals that `rclpy.init` could handle; this engine takes none from the program."""

from enum import IntEnum


class SignalHandlerOptions(IntEnum):
    """The options of rclpy, all without effect here: no handler is installed.

    Ctrl-C raises KeyboardInterrupt.
    """

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3
