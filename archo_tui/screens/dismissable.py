"""The base of screens that lie over another screen and are dismissed."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.await_complete import AwaitComplete
from textual.screen import ScreenResultType

from archo_tui.screens.base import Base
from archo_tui.widgets.line_widget import not_drawn
from archo_tui.widgets.screen_state import ScreenState


class Dismissable(Base[ScreenResultType]):
    """A screen over another one that is dismissed once, however often its keys are pressed.

    If it is dismissed while a further screen lies over it, it goes when that screen has gone. List
    this class last among the bases: Textual looks for styles along the first ones.
    """

    # A STOP closes it, since it asks about the robot before the STOP.
    closes_at_stop: ClassVar[bool] = False
    # A worker waits for an answer that may close the screen; keys pressed meanwhile wait, too.
    is_asking = False
    _not_drawn = ""  # Why the last state could not be drawn.
    _result: tuple[ScreenResultType | None] | None = None  # Set by the first `dismiss`.

    @property
    def is_dismissed(self) -> bool:
        """True once `dismiss` was called, though the screen may still be shown."""
        return self._result is not None

    def dismiss(self, result: ScreenResultType | None = None) -> AwaitComplete:
        """Close the screen with a result, at once or as soon as it is in front.

        The first result counts. What is returned may be awaited only where the screen closes at
        once.
        """
        if self._result is None:
            self._result = (result,)
        if not self.is_mounted:  # Textual still looks for the widgets of the screen.
            self.call_later(self.dismiss)
            return AwaitComplete()
        return super().dismiss(*self._result) if self.is_active else AwaitComplete()

    def stop_waiting(self) -> None:
        """Close the screen for ctrl+c, though the answer that it waits for has not come."""
        self.dismiss()

    def on_screen_resume(self, event: events.ScreenResume) -> None:
        if self._result is not None:
            self.dismiss()

    def update_view(self, view: ScreenState) -> None:
        """Show a new state; if it cannot be drawn, say so once, and leave the other screens be."""
        try:
            self.show_view(view)
            self._not_drawn = ""
        except Exception as error:
            text = not_drawn(error)
            if text != self._not_drawn:
                self._not_drawn = text
                self.notify(f"{type(self).__name__} {text}", severity="error", markup=False)

    def show_view(self, view: ScreenState) -> None:
        """Do nothing; a subclass shows here each new state while the screen is mounted."""
