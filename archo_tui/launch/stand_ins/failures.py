"""The errors of an evaluation, each with the line of the launch file that it is about."""

from __future__ import annotations

from archo_tui.launch.stand_ins.places import Place


class SubstitutionFailure(RuntimeError):
    """The error for a substitution without a value: the launch file is not run.

    Attributes:
        place: The line of the substitution; None if only the traceback has it.
    """

    def __init__(self, msg: object, place: Place | None = None) -> None:
        super().__init__(msg)
        self.place = place


class InvalidLaunchFileError(SubstitutionFailure):
    """The error for a launch file, or an argument given to it, that is wrong."""


class NotHereError(Exception):
    """The error for a part of launch that is not supported: the action that needs it is left out.

    Attributes:
        place: The line of that part.
        is_value: True for a value that an action needs, which may be written elsewhere.
    """

    def __init__(self, text: str, place: Place, is_value: bool = False) -> None:
        super().__init__(text)
        self.place, self.is_value = place, is_value
