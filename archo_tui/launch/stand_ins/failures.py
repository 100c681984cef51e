"""The errors of an evaluation, each with the line of the launch file that it is about."""

from __future__ import annotations

from archo_tui.launch.stand_ins.places import Place


class SubstitutionFailure(RuntimeError):
    """The error for a mistake in a launch file: nothing of the file is run."""

    def __init__(self, msg: object, place: Place | None = None) -> None:
        super().__init__(msg)
        self.place = place


class InvalidLaunchFileError(SubstitutionFailure):
    """The error for a launch file that does not exist, or that describes nothing."""


class SkipActionError(Exception):
    """The error for what is not supported or not here: the action that needs it is left out."""

    def __init__(self, text: str, place: Place, is_value: bool = False) -> None:
        super().__init__(text)
        self.place, self.is_value = place, is_value
