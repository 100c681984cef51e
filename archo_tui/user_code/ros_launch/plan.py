"""The result of an evaluation: the processes that a launch file would start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from archo_tui.user_code.ros_launch.workspace import EntryPoint


@dataclass(frozen=True)
class LaunchedProgram:
    """A process that a launch file starts, with one node as a rule."""

    package: str
    executable: str
    entry_point: EntryPoint
    name: str  # "" if the node keeps the one in its code.
    namespace: str  # With a leading `/`; "" if none is given.
    ros_args: Sequence[str]  # After `--ros-args`: `-r`, `-p`, `--params-file`.
    arguments: Sequence[str]  # Before `--ros-args`.
    respawn: bool  # It is started again after it has ended.
    respawn_delay: float  # s
    start_delay: float  # s after the start of the launch
    environment: Mapping[str, str | None]  # What differs; None for an unset variable.
    file: str  # The path of the launch file.
    line: int


@dataclass(frozen=True)
class LaunchArgument:
    """An argument that a launch file declares, as `--show-args` lists it."""

    name: str
    description: str
    default: str | None  # None: a value must be given.
    choices: Sequence[str]  # Empty if it can have any value.
    is_conditional: bool  # It is declared under some condition only.


@dataclass(frozen=True)
class LaunchNote:
    """A line for the person who launches; as text it is `FILE:LINE: TEXT`."""

    level: str  # `INFO` for what the launch file says itself, `WARN` for what is left out.
    where: str  # `FILE:LINE`, or `FILE`.
    text: str

    def __str__(self) -> str:
        return f"{self.where}: {self.text}"


@dataclass(frozen=True)
class LaunchPlan:
    """The processes that a launch file would start, and its messages."""

    programs: Sequence[LaunchedProgram]  # In the order of their start.
    notes: Sequence[LaunchNote]
    arguments: Sequence[LaunchArgument]  # Also of included files.
    environment: Mapping[str, str | None]  # What differs; None for an unset variable.
    printed: str  # The first 100 kB.
    files: Sequence[str]  # Absolute paths, also of included files.
