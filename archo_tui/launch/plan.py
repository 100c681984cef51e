"""The result of an evaluation: the processes that a launch file would start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from archo_tui.launch.workspace import EntryPoint


@dataclass(frozen=True)
class LaunchedProgram:
    """A process that a launch file starts, with one node as a rule.

    Attributes:
        package: The package.
        executable: The executable of the package.
        entry_point: The function that the executable runs.
        name: The name that the node gets; "" if it keeps the one in its code.
        namespace: The namespace with a leading `/`; "" if none is given.
        ros_args: The words after `--ros-args`: `-r`, `-p` and `--params-file` options with values.
        arguments: The words before `--ros-args`.
        respawn: True if it is started again after it has ended.
        respawn_delay: Seconds between its end and the next start.
        start_delay: Seconds between the start of the launch and that of the program.
        output: `screen`, `log` or `both`.
        environment: Variables that differ from this process's; None for one that is unset.
        file: The path of the launch file.
        line: The line in it.
    """

    package: str
    executable: str
    entry_point: EntryPoint
    name: str
    namespace: str
    ros_args: tuple[str, ...]
    arguments: tuple[str, ...]
    respawn: bool
    respawn_delay: float
    start_delay: float
    output: str
    environment: Mapping[str, str | None]
    file: str
    line: int


@dataclass(frozen=True)
class LaunchArgument:
    """An argument that a launch file declares, as `--show-args` lists it.

    Attributes:
        name: Its name.
        description: The text of the launch file about it; "" for none.
        default: Its default as text; None if it has none, so that a value must be given.
        choices: The values that it can have; empty if it can have any.
        is_conditional: True if it is declared under some condition only.
    """

    name: str
    description: str
    default: str | None
    choices: tuple[str, ...]
    is_conditional: bool


@dataclass(frozen=True)
class LaunchNote:
    """A line for the person who launches; as text it is `FILE:LINE: TEXT`.

    Attributes:
        level: `INFO` for what the launch file says itself, `WARN` for what is left out.
        where: `FILE:LINE`, or `FILE` for what concerns no line.
        text: The message.
    """

    level: str
    where: str
    text: str

    def __str__(self) -> str:
        return f"{self.where}: {self.text}"


@dataclass(frozen=True)
class LaunchPlan:
    """The processes that a launch file would start, and its messages.

    Attributes:
        programs: The processes, in the order in which the launch starts them.
        notes: The messages of the launch file, and what of it is left out.
        arguments: The arguments that the file and those it includes declare.
        environment: The variables that it sets for the whole launch; None for one that is unset.
        printed: The first 100 kB that its code printed.
        files: The absolute paths of the launch file and of those that it includes.
    """

    programs: tuple[LaunchedProgram, ...]
    notes: tuple[LaunchNote, ...]
    arguments: tuple[LaunchArgument, ...]
    environment: Mapping[str, str | None]
    printed: str
    files: tuple[str, ...]
