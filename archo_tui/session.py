"""The composition root: engine, hosted nodes and Robot. Used by the command line and the tests."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from archo_tui import engine, journal, params
from archo_tui.alarms import Alarm, AlarmBoard
from archo_tui.embedded.parameter_files import Override
from archo_tui.errors import ArchoError
from archo_tui.journal import Journal
from archo_tui.leaving import CANCEL, LEAVE

if TYPE_CHECKING:
    from archo_tui.host import Host
    from archo_tui.robot.client import Robot
    from archo_tui.robot.state import Event

_COUNTS = (1, 10, 100, 1000, 10_000, 100_000)  # of a repeated event that the journal notes


@dataclass(frozen=True)
class Options:
    """What the command line says."""

    engine: str = "embedded"
    params_files: Sequence[Path] = ()
    use_sim: bool = False
    namespace: str = "/"
    ros_args: Sequence[str] = ()
    attach: bool = False  # host nothing: operate what is on the graph
    on_disconnect: str = CANCEL  # what becomes of a running goal: CANCEL or LEAVE
    domain_id: int | None = None
    node_makers: Sequence[Any] = field(default=())  # instead of the robot's own nodes


class Session:
    """Everything but the screen. Use as a context manager."""

    robot: Robot
    host: Host

    def __init__(self, options: Options) -> None:
        """Starts the engine and constructs the nodes.

        Raises ArchoError for whatever is the user's to mend, before anything runs.
        """
        self.options = options
        if options.attach:
            _check_attach(options)
        elif options.on_disconnect == LEAVE:
            raise ArchoError("--on-disconnect leave needs --attach: our nodes end with the console")
        self._own_files = [] if options.attach else params.default_files()
        self._overrides = params.load([*self._own_files, *options.params_files])
        engine.activate(options.engine, hosting=not (options.attach or options.node_makers))

        import rclpy
        from rclpy.context import Context
        from rclpy.exceptions import (
            InvalidParameterTypeException,
            InvalidParameterValueException,
            NameValidationException,
        )
        from rclpy.signals import SignalHandlerOptions

        from archo_tui.host import Host
        from archo_tui.robot.client import Robot

        self._context = Context()
        try:
            rclpy.init(
                args=self._ros_args(),
                context=self._context,
                domain_id=options.domain_id,
                signal_handler_options=SignalHandlerOptions.NO,
            )
        except Exception as error:  # ROS has a dozen of them, all for bad arguments
            raise ArchoError((str(error).splitlines() or [repr(error)])[0]) from None
        self.engine = engine.describe(options.engine, self._context)
        self.alarms = AlarmBoard()
        self.journal = Journal(journal.path(), self._journal_troubled)
        try:
            self.robot = Robot(self._context, self._happened)
            self.host = Host(self._context, self.robot.note)
            for make in self._makers():
                self.host.add(make)
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            self._context.try_shutdown()
            raise ArchoError(self._refused(str(error))) from None
        except NameValidationException as error:
            self._context.try_shutdown()
            raise ArchoError(f"{error.name_type} {error.name!r}: {error.error_msg}") from None

    def _journal_troubled(self, reason: str) -> None:
        self.robot.note("WARN", "console", f"cannot be written, going on without it: {reason}")

    def _happened(self, event: Event) -> None:
        """An event came, or came again, on the robot's thread."""
        if event.level not in ("DEBUG", "INFO") and event.count in _COUNTS:
            kind = "command" if event.level == "YOU" else "event"
            what = {"level": event.level, "source": event.source, "text": event.text}
            if event.command:
                what["command"] = event.command
            self.journal.write(event.time, kind, **what, count=event.count)

    def alarmed(self, changed: Iterable[Alarm]) -> None:
        """Alarms have changed their states."""
        for alarm in changed:
            what = {"name": alarm.name, "state": alarm.state.value, "text": alarm.text}
            self.journal.write(time.time(), "alarm", priority=alarm.priority.name, **what)

    def _makers(self) -> Sequence[Any]:
        if self.options.attach:
            return ()
        return self.options.node_makers or _robots_nodes(self.options.use_sim)

    def _ros_args(self) -> list[str]:
        args = ["--ros-args", "--disable-stdout-logs"]
        if self.options.namespace != "/":
            args += ["-r", f"__ns:={self.options.namespace}"]
        for path in (*self._own_files, *self.options.params_files):
            args += ["--params-file", str(path)]
        return [*args, *self.options.ros_args]

    def _refused(self, message: str) -> str:
        """The line for a parameter that a node refused at the start, with file and line."""
        quoted = message.split("'")
        for override in reversed(self._overrides):
            if override.name in quoted:
                return f"{override.where}: {message}"
        return message

    def start(self) -> None:
        """Let everything run."""
        declared = {
            hosted.name: set(hosted.node.list_parameters([], 0).names) for hosted in self.host.nodes
        }
        self.robot.start()
        self.host.start()
        for line in params.unknown(self._users(), declared):
            self.robot.note("WARN", "console", line)

    def _users(self) -> list[Override]:
        """The overrides of the user's own files."""
        own = {str(path) for path in self._own_files}
        return [o for o in self._overrides if o.where.rpartition(":")[0] not in own]

    def close(self) -> list[str]:
        """Stop everything; returns the names of nodes whose callbacks did not return."""
        self.robot.stop()
        stuck = self.host.stop()
        self.journal.close()
        self._context.try_shutdown()
        if self.options.engine == engine.ROS2:
            gc.collect()  # rclpy's contexts hold file descriptors until they are collected
        return stuck

    def __enter__(self) -> Session:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _check_attach(options: Options) -> None:
    if options.engine == engine.EMBEDDED:
        raise ArchoError("--attach needs --engine ros2: the embedded engine ends with this process")
    if options.params_files or options.use_sim:
        raise ArchoError("--attach hosts no nodes: --params-file and --use-sim mean nothing here")


def _robots_nodes(use_sim: bool) -> list[Any]:
    from archo_bringup.battery_monitor import BatteryMonitor
    from archo_bringup.dashboard import Dashboard
    from archo_bringup.fake_battery_drain import FakeBatteryDrain
    from archo_bringup.motor_controller import MotorController

    nodes = [BatteryMonitor, Dashboard, MotorController]
    return [*nodes, FakeBatteryDrain] if use_sim else nodes
