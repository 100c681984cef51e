"""A launch file of the user's own, whose programs run in this process.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from archo_tui.errors import ArchoError
from archo_tui.launch.evaluate import evaluate
from archo_tui.launch.plan import LaunchedProgram, LaunchNote, LaunchPlan
from archo_tui.launch.workspace import Workspace
from archo_tui.robot.state.events import LAUNCH
from archo_tui.user_code.watch import Stamps, stamps

if TYPE_CHECKING:
    from archo_tui.user_code.program import Program

_DOMAIN = "ROS_DOMAIN_ID"


class NothingRunsError(ArchoError):
    """The error of a launch file of which no part can run here.

    Attributes:
        notes: The notes about what it would start, and why that does not run here.
    """

    def __init__(self, path: Path, notes: Sequence[LaunchNote]) -> None:
        """Create the error for a launch file with its notes."""
        super().__init__(f"nothing of {path} runs here")
        self.notes = notes


class LaunchFile:
    """A launch file, evaluated once, and a temporary folder with what its packages install.

    Attributes:
        path: The path of the launch file.
        workspace: The packages of the workspace that the file is in, which it can use.
        notes: The messages of the file, what it prints, and a note for each part that does not run
            here; `programs` adds warnings.
    """

    def __init__(self, path: Path, arguments: Mapping[str, str]) -> None:
        """Evaluate the file in a child process, and wait for it; `close` removes the folder.

        Args:
            path: The path of the launch file.
            arguments: The values of its launch arguments, by name.

        Raises:
            ArchoError: The file is wrong, or nothing of it runs here (NothingRunsError).
        """
        self.path, self._arguments = path, arguments
        self.workspace = Workspace.around(path)
        self._prefix = tempfile.TemporaryDirectory(prefix="archo-launch-")
        try:
            self._plan = self._evaluated(self._prefix.name)
            self.notes = list(self._plan.notes)
            printed = self._plan.printed.splitlines()
            self.notes += [LaunchNote("INFO", str(path), line) for line in printed]
            if not self._plan.programs:
                raise NothingRunsError(path, self.notes)
        except BaseException:
            self.close()
            raise

    def _evaluated(self, prefix: str) -> LaunchPlan:
        return evaluate(str(self.path), self.workspace, Path(prefix), self._arguments)

    def check(self) -> None:
        """Evaluate the file as it is now, to find its mistakes; its programs are not changed.

        Raises:
            ArchoError: The file is wrong.
        """
        with tempfile.TemporaryDirectory(prefix="archo-launch-") as prefix:
            self._evaluated(prefix)

    def programs(self, ros_args: Sequence[str], domain_id: int | None) -> list[Program]:
        """Return the programs of the file, and prepare this process to run them.

        The environment variables that the file sets or removes are set or removed in this process,
        and the programs' modules can be imported. A variable other than ROS_DOMAIN_ID that is set
        for one program only is not set: `notes` gets a warning.

        Args:
            ros_args: ROS arguments that each program gets before its own, from `--ros-args` on.
            domain_id: The ROS domain of a program for which the file sets none.

        Raises:
            NodeFileError: There is no file for the module of a program.
        """
        from archo_tui.user_code.file import ProgramFile
        from archo_tui.user_code.program import Program

        _set_environment(self._plan.environment)
        programs = []
        for launched in self._plan.programs:
            entry_point = launched.entry_point
            entry_point.make_importable()
            self._note_environment(launched)
            domain = launched.environment.get(_DOMAIN)
            programs.append(
                Program(
                    ProgramFile(entry_point.module, entry_point.function),
                    (*ros_args, *launched.ros_args),
                    launched.arguments,
                    _full_name(launched),
                    int(domain) if domain and domain.isdecimal() else domain_id,
                    launched.respawn_delay if launched.respawn else None,
                    launched.start_delay,
                    sees_ros_args=True,
                )
            )
        return programs

    def _note_environment(self, launched: LaunchedProgram) -> None:
        """Warn in `notes` of variables but ROS_DOMAIN_ID that the file sets for one program only.

        They are not set, because the programs share one environment.
        """
        own = dict(launched.environment.items() - self._plan.environment.items()).keys() - {_DOMAIN}
        if own:
            where = f"{Path(launched.file).name}:{launched.line}"
            text = f"{', '.join(sorted(own))} is not set for {launched.executable} alone: without "
            text += "ROS the programs share one environment"
            self.notes.append(LaunchNote("WARN", where, text))

    def current_stamps(self) -> Stamps:
        """Return the stamps of all that the launch reads when it starts.

        These are the launch file and those that it includes, the setup.py files of its workspace,
        and the installed YAML files.
        """
        launch_files = {self.path, *(Path(file).resolve() for file in self._plan.files)}
        setups = {package.folder / "setup.py" for package in self.workspace.packages.values()}
        values = {path.resolve() for path in Path(self._prefix.name).rglob("*.yaml")}
        return stamps({*launch_files, *setups, *values})

    def close(self) -> None:
        """Remove the folder with what its packages install."""
        self._prefix.cleanup()


class HostedLaunchFile:
    """A watched launch file: the console restarts when one of its `current_stamps` changes."""

    def __init__(
        self,
        file: LaunchFile,
        note: Callable[[str, str, str], None],
        restart: Callable[[str], None],
    ) -> None:
        """Watch a launch file.

        Args:
            file: The launch file.
            note: Gets level, source and text of an event about a saved text with a mistake.
            restart: Restarts the console, given the reason.
        """
        self._file, self._note, self._restart = file, note, restart
        self.loaded = file.current_stamps()

    def current_stamps(self) -> Stamps:
        """Return the stamps of the launch file as they are now; see `LaunchFile.current_stamps`."""
        return self._file.current_stamps()

    def reload(self) -> None:
        """Restart the console, unless the file has a mistake now, which becomes an error event."""
        self.loaded = self.current_stamps()
        try:
            self._file.check()
        except ArchoError as error:
            self._note("ERROR", LAUNCH, f"the saved text does not run: {error}")
        else:
            self._restart(f"{self._file.path.name}, or a file that it reads, was saved")


def _set_environment(variables: Mapping[str, str | None]) -> None:
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _full_name(launched: LaunchedProgram) -> str:
    """Return the full name of the node of a program; "" if the launch file gives it none."""
    return f"{launched.namespace.rstrip('/')}/{launched.name}" if launched.name else ""
