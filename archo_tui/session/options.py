"""The options of a session, and the check that they go together."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from archo_tui.base.errors import ArchoError
from archo_tui.base.handover import Handover
from archo_tui.recordings.store import BUDGET
from archo_tui.ros import engine
from archo_tui.station.shutdown import CANCEL, LEAVE


class Launch(NamedTuple):
    """A launch file, and the values of its arguments by name."""

    file: Path
    arguments: Mapping[str, str]


class Options(NamedTuple):
    """The options of a session, as the command line gives them."""

    engine: str = "embedded"
    params_files: Sequence[Path] = ()
    use_sim: bool = False
    namespace: str = "/"
    ros_args: Sequence[str] = ()
    attach: bool = False  # Host no nodes, and operate those on the graph.
    on_disconnect: str = CANCEL  # CANCEL or LEAVE a goal that runs at the end.
    domain_id: int | None = None
    node_makers: Sequence[Any] = ()  # Replace the robot's own nodes.
    node_files: Sequence[Path | str] = ()  # The user's programs, or modules by dotted names.
    arguments: Sequence[str] = ()  # Of the last of them.
    launch: Launch | None = None  # The user's launch file.
    only: bool = False  # Host none of the robot's own nodes.
    watch: bool = False  # Send no command.
    quiet_alarms: bool = False  # Ring no bell.
    robot: Path | None = None  # A robot file; None means ARCHO's.
    interfaces: Sequence[Path] = ()  # Folders with the user's interface packages.
    recordings_limit: int = BUDGET  # Bytes of all recordings together.
    record: Path | None = None  # The folder to which everything is recorded.
    remote: bool = False  # Open a socket for other programs of this user.
    handover: Handover | None = None  # What the process before has left, after a restart.
    # Returns True once for STOPs that were typed before the frontend reads keys.
    stop_was_typed: Callable[[], bool] = lambda: False


_NAMESPACE = re.compile(r"/|(/[A-Za-z_][A-Za-z0-9_]*)+")  # ROS's rule.


def check_options(options: Options) -> None:
    """Raise ArchoError if options, or the path of `record` on the disk, are wrong."""
    if not options.namespace.startswith("/"):
        raise ArchoError(f"--namespace must begin with /: /{options.namespace}")
    if not _NAMESPACE.fullmatch(options.namespace):
        raise ArchoError(
            f"--namespace {options.namespace}: only letters, digits and _ between slashes, "
            "and no digit first"
        )
    if options.launch is not None and options.engine != engine.EMBEDDED:
        raise ArchoError(
            f"launch starts programs without ROS: on ROS 2, ros2 launch {options.launch.file} does "
            "it, and archo-tui --engine ros2 --attach operates them"
        )
    if options.record is not None:
        _check_record(options.record)
    if options.attach:
        _check_attach(options)
    elif options.on_disconnect == LEAVE:
        raise ArchoError(
            "--on-disconnect leave needs --attach: the nodes hosted here end with the console"
        )


def _check_record(path: Path) -> None:
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass  # What is said of its folder below.
    except (OSError, ValueError) as error:  # A path that is too long, for example.
        why = getattr(error, "strerror", None) or error
        raise ArchoError(f"--record {path}: {why}") from None
    else:
        raise ArchoError(f"--record {path}: it exists already: name another bag")
    if not path.parent.is_dir() or not os.access(path.parent, os.W_OK):
        raise ArchoError(f"--record {path}: nothing can be written to {path.parent}")


def _check_attach(options: Options) -> None:
    if options.engine == engine.EMBEDDED:
        raise ArchoError(
            "--attach needs --engine ros2: the embedded engine exists in this process only"
        )
    if options.node_files or options.only:
        raise ArchoError("--attach hosts no nodes: --node and --only have no effect")
    if options.params_files or options.use_sim:
        raise ArchoError("--attach hosts no nodes: --params-file and --use-sim have no effect")
