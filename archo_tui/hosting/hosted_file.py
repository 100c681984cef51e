"""The watched files of nodes and programs, which are restarted when their file was saved."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from archo_tui.hosting.host import Host
from archo_tui.hosting.node_files import NodeFile
from archo_tui.hosting.program_file import ProgramFile
from archo_tui.hosting.programs import Programs
from archo_tui.hosting.watch import Stamps


class HostedFile:
    """A watched node file, whose nodes are restarted when it was saved."""

    def __init__(
        self, host: Host, file: NodeFile, operator_values: Callable[[str], Mapping[str, Any]]
    ) -> None:
        """Watch a file.

        Args:
            host: Runs its nodes.
            file: The file.
            operator_values: Returns the parameters that the operator has set on a node, by its
                name.
        """
        self._host, self._file, self._operator_values = host, file, operator_values

    @property
    def loaded(self) -> Stamps:
        """The stamps of the text that was last loaded, or could not be loaded."""
        return self._file.loaded

    def current_stamps(self) -> Stamps:
        """Return the stamps of the file now, and of what it imports from its folder."""
        return self._file.current_stamps()

    def reload(self) -> None:
        """Run the nodes of the file as it is now."""
        self._host.reload(self._file, self._operator_values)


class HostedProgramFile:
    """A watched file of a program, which is run anew when it was saved."""

    def __init__(self, programs: Programs, file: ProgramFile) -> None:
        """Watch the file of one of the programs."""
        self._programs, self._file = programs, file

    @property
    def loaded(self) -> Stamps:
        """The stamps of the text that last ran, or could not be compiled."""
        return self._file.loaded

    def current_stamps(self) -> Stamps:
        """Return the stamps of the file now, and of what it imports from its folder."""
        return self._file.current_stamps()

    def reload(self) -> None:
        """Run the program as it is now."""
        self._programs.reload(self._file)
