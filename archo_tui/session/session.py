"""The composition root: it makes engine, hosted nodes, robot, station and recorders."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import io
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from archo_tui import __version__
from archo_tui.base.clock import LAST_STAMP, Clock
from archo_tui.base.errors import ArchoError
from archo_tui.base.handover import Handover
from archo_tui.base.paths import config_file, journal_file, state_file
from archo_tui.client.protocol import PROTOCOL
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.state.events import LAUNCH
from archo_tui.robot_file import load as robot_files
from archo_tui.robot_file.model import GoalKind
from archo_tui.ros import engine
from archo_tui.ros.embedded.parameter_files import Override, matches
from archo_tui.ros.names import base_name
from archo_tui.session.options import Options, check_options
from archo_tui.station import parameter_files
from archo_tui.station.journal import Journal, unreleased_stop
from archo_tui.station.places import FILE, Places
from archo_tui.station.station import Station
from archo_tui.station.undo import Edit
from archo_tui.user_code.output import NodeOutput
from archo_tui.user_code.ros_launch.plan import LaunchNote
from archo_tui.user_code.watch import FileWatcher, Watched
from archo_tui.user_code.workspaces import find_nodes, package_shares

if TYPE_CHECKING:
    from rclpy.context import Context
    from rclpy.node import Node

    from archo_tui.console.session import RequestHandler
    from archo_tui.console.socket import Server
    from archo_tui.recordings.console import ConsoleRecorder
    from archo_tui.recordings.recorder import BlackBox
    from archo_tui.robot.robot import Robot
    from archo_tui.robot.state.events import Event
    from archo_tui.user_code.host import Host
    from archo_tui.user_code.launch_file import LaunchFile
    from archo_tui.user_code.program import HostedProgram, Program

_EARLIER = 12 * 3600.0  # Seconds before the start in which a STOP is told.
END = 2.5  # Seconds that an end may take, of the 3 s that docs/ssh.md promises.
_LEAST = 0.2  # Seconds of these that a recording gets in any case.
_POLL = 0.02  # Seconds between two looks for a STOP before the frontend comes.
_READ_STOP = "STOP was read while {}: sent now"


class Session:
    """Everything but the screen: engine, hosted nodes, robot, station, recorders and socket."""

    robot: Robot
    host: Host
    box: BlackBox
    _console_recorder: ConsoleRecorder
    unrecorded = ""  # After `close`: why the last recording was not written, or "".
    restart = Handover()  # What the frontend leaves to the next process.
    _server: Server | None = None
    _stdout: TextIO | None = None  # The standard output before `_output` took its place.
    _output: NodeOutput | None = None
    _listening: tuple[int, str] | None = None  # The socket that was kept for the next process.

    def __init__(self, options: Options, clock: Clock | None = None) -> None:
        """Activate the engine, run the user's programs, and make ARCHO's own nodes.

        ArchoError if something that the user can mend is wrong; nothing runs then.
        """
        check_options(options)
        self._early_events: list[LaunchNote] | None = []  # Until `start`.
        self._has_started = threading.Event()
        self._noted: set[str] = set()  # Nodes of the user whose defaults were told.
        self.options, self._clock = options, clock or Clock()
        self.file = robot_files.load(options.robot or robot_files.default_path())
        self._own_files = [] if options.attach else parameter_files.default_files()
        self._own_overrides = parameter_files.load_files(self._own_files)
        self._user_overrides = parameter_files.load_files(options.params_files)
        self._ends = contextlib.ExitStack()  # The last that `close` does.
        self._launch_file = self._read_launch_file()
        self._node_names, self._workspaces = find_nodes(options.node_files)
        if self._launch_file is not None:
            self._workspaces.append(self._launch_file.workspace)
        interfaces = self._activate()
        self.context = self._make_context()
        file = (options.robot or robot_files.default_path()).absolute()
        # Which robot this is: a later start finds a STOP of it in the journal by that.
        self._place = {"file": str(file), **self._network()}
        self.journal = Journal(journal_file(), self._place)
        self._ends.callback(self.journal.close)
        try:
            self._make_robot()
            self.station = self._make_station()
            self.host.operator_values = self.station.edits.values_set
            if options.handover is not None:
                self._resume(options.handover)
            self._programs = self._user_programs()
            self._ends.enter_context(package_shares(self._workspaces))
            if self._programs:  # One may drive before the next has begun.
                self._count_typed_stop()
                self._open()
                name = "early STOPs"
                threading.Thread(target=self._send_early_stops, name=name, daemon=True).start()
            self._host_nodes()
        except BaseException as error:
            self._undo_init()
            mistake = self._mistake_of(error)
            if mistake:
                raise ArchoError(mistake) from None
            raise
        self._watch = FileWatcher(
            self._watched_files(interfaces), partial(self.robot.note, "ERROR", "console")
        )

    def _open(self) -> None:
        """Start the client and the socket."""
        self.robot.start()
        if self._server is not None:
            self._server.start()

    def _send_early_stops(self) -> None:
        """Send each STOP that is read before `start`; the frontend sends it again, and replies."""
        sent = self.robot.stops.answered
        while not self._has_started.wait(_POLL):
            self._count_typed_stop()
            if self.robot.stops.count > sent:
                sent = self.robot.stops.count
                asyncio.run(self.robot.emergency_stop())

    def _count_typed_stop(self) -> None:
        """Count a STOP that was typed since the last look: no program begins behind it."""
        if self.options.stop_was_typed():
            self.robot.stops.register()
            self.robot.note("YOU", "console", _READ_STOP.format("the console restarted"))

    def _stop_gate(self) -> Callable[[], bool]:
        """Return what is true once a STOP was read, here or elsewhere, after this call."""
        gate = self.robot.stops.gate()
        return lambda: gate.is_shut

    def _make_server(self) -> Server | None:
        """Return the server of the socket, not started yet; None on Windows, which has none."""
        if sys.platform == "win32":
            return None
        from archo_tui.console.socket import Server

        def make_handler() -> RequestHandler:
            from archo_tui.console.session import RequestHandler

            return RequestHandler(self.station)

        warn = partial(self.robot.note, "WARN", "console")
        return Server(make_handler, self._hello(), self.robot.stops, warn)

    def _hello(self) -> dict[str, Any]:
        """Return what the socket first tells other programs: see docs/protocol.md."""
        return {
            "protocol": PROTOCOL,
            "version": __version__,
            "robot": self.file.name,
            **self._network(),
            "pid": os.getpid(),
            "watching": self.options.watch,
        }

    def _network(self) -> dict[str, Any]:
        """Return where the robot is, as the socket and the journal name it."""
        is_embedded = self.options.engine == engine.EMBEDDED
        return {
            "namespace": self.options.namespace,
            "engine": self.options.engine,
            "domain": None if is_embedded else self.context.get_domain_id(),
        }

    def _make_context(self) -> Context:
        """Initialize rclpy; ArchoError for wrong arguments. The engine must have been activated."""
        import rclpy
        from rclpy.context import Context
        from rclpy.signals import SignalHandlerOptions

        context, options = Context(), self.options
        try:
            rclpy.init(
                args=self._ros_args(),
                context=context,
                domain_id=options.domain_id,
                signal_handler_options=SignalHandlerOptions.NO,
            )
        except Exception as error:  # ROS has a dozen exceptions for bad arguments.
            text = (str(error).splitlines() or [repr(error)])[0]
            if text.startswith("["):  # rcl only lists the unknown arguments.
                text = f"unknown ROS arguments: {text}"
            raise ArchoError(text) from None
        self._ends.callback(rclpy.try_shutdown, context=context)
        if (options.node_files or options.launch) and options.engine == engine.EMBEDDED:
            from archo_tui.user_code import thread

            self._ends.callback(thread.install())  # Which restores Python's own functions.
        return context

    def _activate(self) -> dict[str, Path]:
        """Activate the engine, and return the user's own interface packages, folders by name."""
        options = self.options
        own: dict[str, Path] = {}
        self._mistakes: list[str] = []  # In the user's interface packages.
        others = options.attach or options.node_makers or options.only
        of_workspaces = [p for w in self._workspaces for p in w.interface_packages.values()]
        if folders := [*of_workspaces, *options.interfaces]:
            from archo_tui.user_code import interfaces as own_interfaces

            own, self._mistakes = own_interfaces.find(folders, options.engine)
        engine.activate(options.engine, hosting=not others, own=own)
        return own

    def _read_launch_file(self) -> LaunchFile | None:
        if self.options.launch is None:
            return None
        from archo_tui.user_code.launch_file import LaunchFile

        launch_file = LaunchFile(*self.options.launch)
        self._ends.callback(launch_file.close)
        return launch_file

    def _make_robot(self) -> None:
        """Make the black box, the client's node, and the host, which has no nodes yet."""
        from archo_tui.recordings.console import ConsoleRecorder, attachments
        from archo_tui.recordings.recorder import BlackBox
        from archo_tui.robot.robot import Robot
        from archo_tui.user_code.host import Host

        self.box = BlackBox(
            state_file("recordings"),
            self._clock,
            lambda *event: self.robot.note(*event),
            lambda: attachments(self.file),
            self.options.recordings_limit,
            self.options.record,
        )
        self._console_recorder = ConsoleRecorder(self.box)
        self.robot = Robot(
            self.context,
            self.file,
            self._clock,
            self._record_event,
            self.box.receive,
            watching=self.options.watch,
        )
        robot = self.robot
        self.host = Host(
            *(self.context, self._note_early, robot.end_goals_of_node),
            early_stop_request=robot.early_stop_request,
            on_early_stop=robot.on_early_stop,
            gate=self._stop_gate,
            on_restored=robot.on_parameters_restored,
            make_program=self._make_program,
            on_spin=self._note_own_defaults,
        )
        robot.own_nodes = self.host.names
        robot.unended_nodes = self.host.unended_names
        self._server = self._make_server() if self.options.remote else None
        self._take_over_stops()

    def _make_station(self) -> Station:
        options = self.options
        places = Places(self.robot.file, config_file(FILE))
        places.load()
        if places.fault:
            self.robot.note("WARN", "console", places.fault)
        return Station(
            self.robot,
            self.host,
            self.journal,
            self._console_recorder,
            self._clock,
            engine=engine.describe(options.engine, self.context),
            namespace=options.namespace,
            attached=options.attach,
            on_disconnect=options.on_disconnect,
            quiet=options.quiet_alarms,
            unseen=engine.no_node_hint(options.engine, self.context),
            file_is_default=options.robot is None,
            places=places,
        )

    def _mistake_of(self, error: BaseException) -> str:
        """Return rclpy's error about a parameter or a name as one line; "" for any other error."""
        from rclpy.exceptions import (
            InvalidParameterTypeException,
            InvalidParameterValueException,
            NameValidationException,
        )

        if isinstance(error, (InvalidParameterTypeException, InvalidParameterValueException)):
            return self._refusal_line(str(error))
        if isinstance(error, NameValidationException):
            text, name = str(error).splitlines()[:2]  # The third line points at the character.
            return f"{text} {name.strip()}"
        return ""

    def _take_over_stops(self) -> None:
        """Count the STOP of a restart, and take over the socket, whose clients may have sent one.

        It is called before a node is made, since each node carries out a counted STOP first.
        """
        left = self.options.handover
        if left is None:
            return
        if left.stop:
            self.robot.stops.register()
        if left.listening is not None and self._server is not None:
            self._server.adopt(*left.listening)

    def _resume(self, left: Handover) -> None:
        """Take over what the process before a restart has left, and say so."""
        station = self.station
        if left.stop:
            self.send_stop("the console restarted")
        station.edits.restore(Edit(*edit) for edit in left.edits)
        known = {(kind.id, kind.action): kind for kind in self.file.goals}
        station.goals.restore(
            [
                QueuedGoal(known.get((kind[0], kind[2]), GoalKind(*kind)), values)
                for *kind, values in left.goals
            ]
        )
        self.robot.note("YOU", "console", f"{left.why}: restarted")

    def send_stop(self, when: str) -> None:
        """Send a STOP that a frontend before has counted, as soon as the next one comes."""

        async def send() -> None:
            await self.robot.emergency_stop()

        self.robot.note("YOU", "console", _READ_STOP.format(when))
        self.station.post(send)

    def hand_over(self) -> Handover:
        """Return `restart` with what this process leaves to the next; call `close` first."""
        station = self.station
        # Of a later STOP it is not sure that it has left.
        is_later = self.robot.stops.count > station.stops_before_restart
        is_stopped = is_later or bool(station.restart_blocker)
        goals = [
            [goal.kind.id, goal.kind.title, goal.kind.action, goal.kind.type, dict(goal.values)]
            for goal in station.queue.waiting
            if not goal.requester.waits  # Else its client was told.
        ]
        return self.restart._replace(
            stop=is_stopped,
            goals=goals,
            edits=[*station.edits.edits],
            listening=self._listening,
        )

    def _watched_files(
        self, interfaces: dict[str, Path]
    ) -> list[tuple[Watched, Callable[[], object]]]:
        """Return the user's own files, each with what a change does: reload it, or restart."""
        restarts: list[LaunchFile | OwnInterfaces] = []
        if self._launch_file is not None:
            restarts.append(self._launch_file)
        if interfaces:
            from archo_tui.user_code.interfaces import OwnInterfaces

            restarts.append(OwnInterfaces(interfaces))
        return [
            *((p.file, partial(self.host.reload, p.file)) for p in self._programs),
            *((f, partial(f.reload, self.robot.note, self.station.restart)) for f in restarts),
        ]

    def _undo_init(self) -> None:
        """End what the constructor has begun so far, before it raises."""
        self._has_started.set()
        if self._server is not None:
            self._server.close()
        if hasattr(self, "host"):  # The nodes that were made have threads, which wait.
            self.host.stop()
        if hasattr(self, "robot"):
            self.robot.close()
        self._ends.close()
        self._release_output()

    def _release_output(self) -> None:
        if self._output is not None and sys.stdout is self._output:
            sys.stdout = self._stdout

    def _record_event(self, event: Event) -> None:
        """Give an event to the recorder and to the journal. Called on the robot's thread."""
        self._console_recorder.record_event(event)
        self.journal.record(event)

    def _look_for_earlier_stop(self) -> None:
        """Tell the station of a STOP in the journal that no release followed, on a thread.

        Only STOPs of the last 12 h count, and only with `--attach`, if the robot file has a release
        and no report of a stop.
        """
        stop, motion = self.file.stop, self.file.motion
        reports_stop = motion is not None and motion.reports_stop
        if not self.options.attach or stop is None or not stop.release or reports_stop:
            return
        since = self.station.clock.now() - _EARLIER

        def look() -> None:
            found = unreleased_stop(journal_file(), self._place, since)
            self.station.earlier_stop = found

        threading.Thread(target=look, name="journal before", daemon=True).start()

    def _host_nodes(self) -> None:
        """Add to the host the nodes and programs of the user, then the robot's own nodes.

        A robot's node is left out if the user's has the same name; all are with `--attach` or
        `--only`. What the user's files print meanwhile becomes events.
        """
        # What programs print before the frontend comes is an event as well.
        if self._programs and not isinstance(sys.stdout, NodeOutput):
            self._stdout = sys.stdout
            self._output = NodeOutput(sys.stdout or io.StringIO(), self._note_early)
            sys.stdout = self._output
        output = sys.stdout
        self._begin_programs()
        sys.stdout = output  # Whatever a program has done to it.
        if self.options.attach or self.options.only:
            return
        for make in self.options.node_makers:
            self.host.add(make)
        if self.options.node_makers:
            return
        taken = {base_name(name) for name in self.host.names()}
        # rclpy's own errors: in one process DDS allows one type a topic; or the user's interfaces.
        name, expected = "the robot's own nodes", (RuntimeError, ImportError, AttributeError)
        try:
            for name, kind in _robots_nodes(self.options.use_sim).items():
                if name not in taken:
                    self.host.add(partial(_make_own, kind, self._own_ros_args()))
        except expected as error:
            from archo_tui.user_code.errors import reason_of

            text = f"{name}: {reason_of(error)}"
            raise ArchoError(f"{text}: --only leaves the robot's own nodes out") from None

    def _note_early(self, level: str, source: str, text: str) -> None:
        """Add an event, and keep it for the error of a launch of which nothing runs."""
        if self._early_events is not None:
            self._early_events.append(LaunchNote(level, source, text))
        self.robot.note(level, source, text)

    def _begin_programs(self) -> None:
        """Run the user's programs, each of which ends alone; one of the launch file may fail.

        NothingRunsError if all of those have crashed.
        """
        for program in self._programs:
            self.host.add_program(program, may_fail=self._launch_file is not None)
        if self._launch_file is not None and self.host.all_have_crashed:
            from archo_tui.user_code.launch_file import NothingRunsError

            notes = [*self._launch_file.notes, *(self._early_events or ())]
            raise NothingRunsError(self._launch_file.path, notes)

    def printer_of_children(self) -> Callable[[str], object] | None:
        """Return what makes an event of a line that a child of the user's program prints.

        None if several files or none could have started it.
        """
        if len(self._programs) != 1:
            return None
        output = NodeOutput(io.StringIO(), self.robot.note)

        def print_line(line: str) -> None:
            threading.current_thread().name = self.host.programs[0].name
            output.write(line)

        return print_line

    def _make_program(self, *arguments: Any) -> HostedProgram:
        """Return a new program of the engine's kind: a thread, or on ROS 2 a child process."""
        if self.options.engine == engine.EMBEDDED:
            from archo_tui.user_code.thread import ProgramThread

            return ProgramThread(*arguments)
        if sys.platform != "win32":
            from archo_tui.user_code.child import ProgramChild

            is_ready = isinstance(sys.stdout, NodeOutput)  # As that of `check` is.
            output = sys.stdout if is_ready else NodeOutput(io.StringIO(), self.robot.note)
            return ProgramChild(*arguments, output=output)
        raise ArchoError("--node with --engine ros2 does not work on Windows")

    def _user_programs(self) -> list[Program]:
        """Return the user's programs, those of the launch file last."""
        from archo_tui.user_code.file import ProgramFile
        from archo_tui.user_code.program import Program

        args, domain = tuple(self._ros_args()), self.options.domain_id
        files = [ProgramFile(given) for given in self._node_names]
        programs = [Program(file, args, domain_id=domain) for file in files]
        if programs:  # `--node FILE -- ARG ...`
            programs[-1] = programs[-1]._replace(arguments=tuple(self.options.arguments))
        if self._launch_file is not None:
            programs += self._launch_file.programs(args, domain)
        return programs

    def _ros_args(self) -> list[str]:
        args = ["--ros-args", "--disable-stdout-logs"]
        if self.options.namespace != "/":
            args += ["-r", f"__ns:={self.options.namespace}"]
        for path in self.options.params_files:
            args += ["--params-file", str(path)]
        return [*args, *self.options.ros_args]

    def _own_ros_args(self) -> list[str]:
        """Return the ROS arguments of ARCHO's own nodes: its parameter files, then the user's.

        A node's own arguments win over those of its context, so they hold the user's once more.
        """
        files = [word for path in self._own_files for word in ("--params-file", str(path))]
        return ["--ros-args", *files, *self._ros_args()[1:]]

    def _refusal_line(self, message: str) -> str:
        """Return a node's refusal of a parameter, with the file and line that gave the value."""
        text, _, name = message.rpartition(": ")  # rclpy's errors end with the parameter's name.
        for override in reversed([*self._own_overrides, *self._user_overrides]):
            # Otherwise it is one of --ros-args.
            if override.name == name and str(override.value) in text:
                return f"{override.where}: {text}"
        return message

    def start(self) -> None:
        """Start the client, ARCHO's own nodes, the watch of the user's files, and the socket."""
        declared = {
            hosted.name: set(hosted.node.list_parameters([], 0).names) for hosted in self.host.nodes
        }
        self._early_events = None
        if self._programs:  # It was opened before they began.
            self.robot.look_at_graph()
        else:
            self._open()
        self._look_for_earlier_stop()
        self.host.start()
        self._watch.start()
        self._has_started.set()
        for line in self._mistakes:
            self.robot.note("WARN", "interfaces", f"not read: {line}")
        for note in self._launch_file.notes if self._launch_file is not None else ():
            self.robot.note(note.level, LAUNCH, str(note))
        if not self._programs:  # Nobody knows which nodes and parameters a program will have.
            for line in parameter_files.unknown_lines(self._all_user_overrides(), declared):
                self.robot.note("WARN", "console", line)
        if self.station.clock.now() > LAST_STAMP:
            text = "the clock is past January 2038: stamps in messages stay at its 19th"
            self.robot.note("WARN", "console", text)

    def _note_own_defaults(
        self, program: HostedProgram, node: str, declared: Sequence[str]
    ) -> None:
        """Say once which parameters of a user's node ARCHO's own files do not set. Any thread."""
        if node in self._noted or self.options.only:
            return
        self._noted.add(node)
        own = [o for o in self._own_overrides if matches(o.pattern, node)]
        given = {o.name for o in self._all_user_overrides() if matches(o.pattern, node)}
        names = {o.name for o in own} & {*declared} - given
        if names:
            named = {Path(o.where.rpartition(":")[0]).name for o in own}
            text = f"{', '.join(sorted(names))}: the default of {program.file.path.name}; "
            text += f"{', '.join(sorted(named))} is for ARCHO's own node, --params-file "
            text += "gives it to yours"
            self.robot.note("INFO", node.lstrip("/"), text)

    def _all_user_overrides(self) -> list[Override]:
        return [*self._user_overrides, *parameter_files.parse_typed(self.options.ros_args)]

    def close(self, *, restarts: bool = False) -> list[str]:
        """Stop everything, and return the names of the nodes and programs that did not end.

        Recordings that still go on are written in 2.5 s at most. `restarts` keeps the socket for
        `hand_over`.
        """
        ends = time.monotonic() + END
        self.box.finish()
        self._watch.stop()
        if self._server is not None and restarts:
            self._listening = self._server.keep()
        elif self._server is not None:
            self._server.close()
        self.robot.close()
        stuck = self.host.stop()
        self.unrecorded = self.box.close(max(ends - time.monotonic(), _LEAST))
        self._ends.close()
        self._release_output()
        if self.options.engine == engine.ROS2:
            gc.collect()  # rclpy's contexts hold file descriptors until then.
        return stuck

    def __enter__(self) -> Session:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _make_own(
    kind: Any, ros_args: Sequence[str], *, context: Context, cli_args: Sequence[str] = ()
) -> Node:
    """Make one of ARCHO's own nodes; `cli_args` are those of a copy, which has another name."""
    node: Node = kind(context=context, cli_args=[*ros_args, *cli_args])
    return node


def _robots_nodes(use_sim: bool) -> dict[str, Any]:
    """Return the classes of ARCHO's own nodes by their names; the simulation's if `use_sim`."""
    from archo_bringup.battery_monitor import BatteryMonitor
    from archo_bringup.dashboard import Dashboard
    from archo_bringup.motor_controller import MotorController

    nodes = {
        "battery_monitor": BatteryMonitor,
        "dashboard": Dashboard,
        "motor_controller": MotorController,
    }
    if use_sim:
        from archo_bringup.fake_battery_drain import FakeBatteryDrain

        nodes["fake_battery_drain"] = FakeBatteryDrain
    return nodes
