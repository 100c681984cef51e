"""The errors of an evaluation, each with the line of the launch file that it is about."""

from __future__ import annotations

from archo_tui.launch.stand_ins.places import Place


class SubstitutionFailure(RuntimeError):
    """The error for a mistake in a launch file, such as a substitution without a value.

    It ends the evaluation: nothing of the launch file is run.

    Attributes:
        place: The line of the mistake; None if only the traceback has it.
    """

    def __init__(self, msg: object, place: Place | None = None) -> None:
        super().__init__(msg)
        self.place = place


class InvalidLaunchFileError(SubstitutionFailure):
    """The error for a launch file that does not exist, or that describes nothing.

    It describes nothing without a `generate_launch_description()` that returns a description.
    """


class SkipActionError(Exception):
    """The error for what is not supported or not here: the action that needs it is left out.

    A note tells the text of the error.

    Attributes:
        place: The line of the part that is not supported or not here.
        is_value: True for a value that an action needs, which may be written on another line.
    """

    def __init__(self, text: str, place: Place, is_value: bool = False) -> None:
        super().__init__(text)
        self.place, self.is_value = place, is_value
