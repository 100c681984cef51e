"""The base of all screens, and of those that lie over another one."""

from __future__ import annotations

from typing import ClassVar

from textual import events
from textual.await_complete import AwaitComplete
from textual.events import Event, Resize
from textual.geometry import Offset
from textual.screen import Screen, ScreenResultType
from textual.widget import Widget

from archo_tui.text.state import not_drawn
from archo_tui.widgets.field import Field
from archo_tui.widgets.panel import ScreenState


class Base(Screen[ScreenResultType]):
    """The base of all screens, which survives fast resizes and clicks on widgets just removed."""

    async def on_event(self, event: Event) -> None:
        """Handle an event; a Resize is handled with the size that the terminal has now.

        Each change of size makes a screen send itself one more Resize. If the terminal is resized
        again before that is handled, Textual goes back and forth between the two sizes for ever. A
        new Resize is made, since all screens get the same one, and would find in it what another
        screen has marked.
        """
        size = self.app.size
        await super().on_event(Resize(size, size) if isinstance(event, Resize) else event)

    def set_focus(
        self, widget: Widget | None, scroll_visible: bool = True, from_app_focus: bool = False
    ) -> None:
        """Focus a widget; if it is a field, select its text, so that typing replaces the text.

        Textual would select it only after keys that were typed in the meantime. None means
        `nearest_focus` while the terminal has the focus; `from_app_focus` selects nothing.
        """
        if widget is None and self.app.app_focus:
            widget = self.nearest_focus
        is_new = widget is not self.focused and not from_app_focus
        super().set_focus(widget, scroll_visible, from_app_focus)
        if is_new and isinstance(widget, Field):
            widget.action_select_all()

    @property
    def nearest_focus(self) -> Widget | None:
        """The widget with the focus if it is shown, else the first one that can have it."""
        chain = self.focus_chain
        return self.focused if self.focused in chain else next(iter(chain), self.focused)

    def _compositor_refresh(self) -> None:
        """Draw what has changed; behind a dialog, have the dialog draw that, and no more.

        Textual would draw all of this screen with its next change.
        """
        super()._compositor_refresh()
        if self is not self.app.screen:
            self._repaint_required = False

    def get_widget_and_offset_at(self, x: int, y: int) -> tuple[Widget | None, Offset | None]:
        """Return the widget at a cell and the place in its text; None and None if there is none.

        A widget that was removed stays on the screen for a moment. Textual would begin a selection
        in its parent, which is None by then.
        """
        widget, offset = super().get_widget_and_offset_at(x, y)
        is_removed = widget is not None and widget is not self and widget.parent is None
        return (None, None) if is_removed else (widget, offset)


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
