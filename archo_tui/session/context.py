"""The rclpy context of a session: its initialization and its shutdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from archo_tui.base.errors import ArchoError


class RclpyContext:
    """An initialized rclpy context, until `shutdown`."""

    def __init__(
        self,
        ros_args: Sequence[str],
        domain_id: int | None,  # None means that of the environment.
        *,
        has_program_threads: bool,  # Python is patched for them.
    ) -> None:
        """Initialize rclpy; ArchoError for wrong arguments."""
        self.context = Context()
        try:
            rclpy.init(
                args=[*ros_args],
                context=self.context,
                domain_id=domain_id,
                signal_handler_options=SignalHandlerOptions.NO,
            )
        except Exception as error:  # ROS has a dozen exceptions for bad arguments.
            text = (str(error).splitlines() or [repr(error)])[0]
            if text.startswith("["):  # rcl only lists the unknown arguments.
                text = f"unknown ROS arguments: {text}"
            raise ArchoError(text) from None
        self._uninstall: Callable[[], None] | None = None
        if has_program_threads:
            from archo_tui.user_code import thread

            self._uninstall = thread.install()

    def shutdown(self) -> None:
        """Shut the context down, and restore Python's own functions."""
        if self._uninstall is not None:
            self._uninstall()
        rclpy.try_shutdown(context=self.context)
