"""The base of screens that lie over another screen and are dismissed."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.await_complete import AwaitComplete
from textual.screen import ScreenResultType

from archo_tui.screens.base import Base
from archo_tui.widgets.screen_state import ScreenState


class Dismissable(Base[ScreenResultType]):
    """A screen that is dismissed once, however often its keys are pressed.

    If it is dismissed while another screen lies over it, it goes when that one has gone; Textual
    would dismiss the one on top, even while that is still being built.

    List it as the last base of a class: Textual looks for styles and component classes along the
    first bases.

    Attributes:
        closes_at_stop: True if a STOP closes it, since it asks about the robot before the STOP.
        is_asking: True while a worker waits for an answer that may close it; keys that are pressed
            meanwhile wait, too.
    """

    closes_at_stop: ClassVar[bool] = False
    is_asking = False
    _result: tuple[ScreenResultType | None] | None = None  # Set by the first `dismiss`.

    @property
    def is_dismissed(self) -> bool:
        """True once it was dismissed, though it may still be shown."""
        return self._result is not None

    def dismiss(self, result: ScreenResultType | None = None) -> AwaitComplete:
        """Close the screen with a result; a further call changes nothing.

        Args:
            result: What its opener gets.
        """
        if self._result is None:
            self._result = (result,)
        if not self.is_mounted:  # Textual still looks for the widgets of the screen.
            self.call_later(self.dismiss)
            return AwaitComplete()
        return super().dismiss(*self._result) if self.is_active else AwaitComplete()

    def stop_waiting(self) -> None:
        """Close the screen, though the answer that it waits for has not come."""
        self.dismiss()

    def on_screen_resume(self, event: events.ScreenResume) -> None:
        if self._result is not None:
            self.dismiss()

    def show_view(self, view: ScreenState) -> None:
        """Bring what is shown up to date; called with each new state of the screen."""
