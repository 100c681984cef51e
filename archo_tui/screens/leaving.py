"""A screen over others ends once, however often its keys are pressed."""

from __future__ import annotations

from typing import ClassVar

from textual.await_complete import AwaitComplete
from textual.screen import ScreenResultType

from archo_tui.screens.base import Base
from archo_tui.station.station import View


class Leaving(Base[ScreenResultType]):
    """A screen that is dismissed once; under another one, when that has gone.

    Textual would dismiss the one on top, even while that is still being built. It is the last base:
    Textual looks for styles and component classes along the first.
    """

    closes_at_stop: ClassVar[bool] = False  # its question was about the robot before the STOP
    is_asking = False  # a worker waits for an answer that may close it: the keys behind wait, too
    _left: tuple[ScreenResultType | None] | None = None  # with what, once that is known

    @property
    def has_left(self) -> bool:
        """True when it was dismissed, whether it has gone yet or not."""
        return self._left is not None

    def dismiss(self, result: ScreenResultType | None = None) -> AwaitComplete:
        """A second enter, or an answer that comes late, changes nothing."""
        if self._left is None:
            self._left = (result,)
        if not self.is_mounted:  # its parts are looked for while it is built
            self.call_later(self.dismiss)
            return AwaitComplete()
        return super().dismiss(*self._left) if self.is_active else AwaitComplete()

    def stop_waiting(self) -> None:
        """Leave, though the answer that it waits for has not come."""
        self.dismiss()

    def on_screen_resume(self) -> None:
        if self._left is not None:
            self.dismiss()

    def follow(self, view: View) -> None:
        """There is a new view: those that show what there is now bring it up to date."""
