"""The base of all screens, which mends what fails in Textual's own at unlucky moments."""

from __future__ import annotations

from textual.events import Event, Resize
from textual.geometry import Offset
from textual.screen import Screen
from textual.widget import Widget

from archo_tui.screen.widgets.field import Field


class Base(Screen[None]):
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
