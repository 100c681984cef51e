"""The rclpy context of a session: its initialization and its shutdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_default_context

from archo_tui.errors import ArchoError
from archo_tui.hosting import global_executor


class RclpyContext:
    """An initialized rclpy context, until `shutdown`.

    While it hosts nodes of the user's files, `rclpy.shutdown` and `rclpy.try_shutdown` are
    replaced: outside of programs they raise RuntimeError.
    """

    def __init__(
        self,
        ros_args: Sequence[str],
        domain_id: int | None,  # None means that of the environment.
        *,
        hosts_files: bool,  # Their nodes often have no context: the default one is taken.
        hosts_programs: bool,  # They run in threads here, whose shutdown ends them alone.
    ) -> None:
        """Initialize rclpy, and patch it for what is hosted; ArchoError for wrong arguments."""
        self._is_default = hosts_files
        self.context = get_default_context() if hosts_files else Context()
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
        self._shutdowns = rclpy.shutdown, rclpy.try_shutdown
        self._uninstall: list[Callable[[], None]] = []
        in_program: Callable[[], bool] = _never
        if hosts_programs:
            from archo_tui.hosting import program_thread

            in_program = program_thread.in_program
            self._uninstall.append(program_thread.install())
        if hosts_files:
            rclpy.shutdown, rclpy.try_shutdown = (
                _only_in_programs(in_program, shutdown) for shutdown in self._shutdowns
            )
            self._uninstall.append(global_executor.install())

    def shutdown(self) -> None:
        """Shut the context down, and restore rclpy's own functions."""
        rclpy.shutdown, rclpy.try_shutdown = self._shutdowns
        for uninstall in self._uninstall:
            uninstall()
        # rclpy makes a new default context unless this one is named.
        rclpy.try_shutdown(context=None if self._is_default else self.context)


def _never() -> bool:
    return False


def _only_in_programs(
    in_program: Callable[[], bool], shutdown: Callable[..., None]
) -> Callable[..., None]:
    """Return a `shutdown` that raises RuntimeError unless a program calls it: it would end all."""

    def shutdown_of_program(**options: Any) -> None:
        if not in_program():
            text = "rclpy.shutdown() would end every node here: call it in main() only"
            raise RuntimeError(text)
        shutdown(**options)

    return shutdown_of_program
