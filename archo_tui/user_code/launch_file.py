"""A launch file of the user's own, whose programs run in this process.

This module is imported before the engine is chosen, and so must not import rclpy.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from archo_tui.base.errors import ArchoError
from archo_tui.robot.state.events import LAUNCH
from archo_tui.user_code.ros_launch.evaluate import evaluate
from archo_tui.user_code.ros_launch.plan import LaunchedProgram, LaunchNote, LaunchPlan
from archo_tui.user_code.ros_launch.workspace import Workspace
from archo_tui.user_code.watch import Stamps, stamps

if TYPE_CHECKING:
    from archo_tui.user_code.program import Program

_DOMAIN = "ROS_DOMAIN_ID"


class NothingRunsError(ArchoError):
    """The error of a launch file of which no part can run here, with notes that say why."""

    def __init__(self, path: Path, notes: Sequence[LaunchNote]) -> None:
        super().__init__(f"nothing of {path} runs here")
        self.notes = notes


class LaunchFile:
    """A launch file, evaluated once, and a temporary folder with what its packages install.

    `notes` has its messages, what it prints, and what of it does not run here; `programs` adds
    warnings.
    """

    def __init__(self, path: Path, arguments: Mapping[str, str]) -> None:
        """Evaluate the file in a child process, and wait for it; `close` removes the folder.

        NothingRunsError if nothing of it runs here.
        """
        self.path, self._arguments = path, arguments
        self.workspace = Workspace.around(path)  # That it is in, and whose packages it can use.
        self._prefix = tempfile.TemporaryDirectory(prefix="archo-launch-")
        try:
            self._plan = self._evaluated(self._prefix.name)
            self.notes = list(self._plan.notes)
            printed = self._plan.printed.splitlines()
            self.notes += [LaunchNote("INFO", str(path), line) for line in printed]
            if not self._plan.programs:
                raise NothingRunsError(path, self.notes)
            self.loaded = self.current_stamps()
        except BaseException:
            self.close()
            raise

    def _evaluated(self, prefix: str) -> LaunchPlan:
        return evaluate(str(self.path), self.workspace, Path(prefix), self._arguments)

    def reload(self, note: Callable[[str, str, str], None], restart: Callable[[str], None]) -> None:
        """Restart the console, unless the file has a mistake now, which becomes an error event."""
        self.loaded = self.current_stamps()
        try:
            with tempfile.TemporaryDirectory(prefix="archo-launch-") as prefix:
                self._evaluated(prefix)
        except ArchoError as error:
            note("ERROR", LAUNCH, f"the saved text does not run: {error}")
        else:
            restart(f"{self.path.name}, or a file that it reads, was saved")

    def programs(self, ros_args: Sequence[str], domain_id: int | None) -> list[Program]:
        """Return the programs of the file, and prepare this process to run them.

        The environment variables that the file sets or removes are set or removed in this process,
        and the programs' modules can be imported. A variable other than ROS_DOMAIN_ID that is set
        for one program only is not set: `notes` gets a warning. Each gets `ros_args`, from
        `--ros-args` on, before its own, and `domain_id` unless the file sets one.
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
                    (*launched.arguments,),
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


def _set_environment(variables: Mapping[str, str | None]) -> None:
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _full_name(launched: LaunchedProgram) -> str:
    """Return the full name of the node of a program; "" if the launch file gives it none."""
    return f"{launched.namespace.rstrip('/')}/{launched.name}" if launched.name else ""
