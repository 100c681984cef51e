"""What all screens have: they hold where Textual's own fail at unlucky moments."""

from __future__ import annotations

from textual.events import Resize
from textual.geometry import Offset
from textual.screen import Screen, ScreenResultType
from textual.widget import Widget

from archo_tui.widgets.field import Field


class Base(Screen[ScreenResultType]):
    """A screen that is laid out for the terminal as it is, and clicked where something is."""

    async def _on_resize(self, event: Resize) -> None:
        """Lay out for the size that the terminal has now.

        Each change of size makes a screen send itself one more event. When the terminal is resized
        again before that one is taken, the two chase each other for ever in Textual, and no key is
        taken any more.
        """
        event.prevent_default()  # Textual would call its own as well
        size = self.app.size
        await super()._on_resize(event if event.size == size else Resize(size, size))

    def set_focus(
        self, widget: Widget | None, scroll_visible: bool = True, from_app_focus: bool = False
    ) -> None:
        """Focus a widget, and select the text of a field: what is typed replaces it.

        Textual selects when the field hears of its focus, which is behind keys that came at once.
        With `from_app_focus` what is typed goes on where it was.
        """
        comes = widget is not self.focused and not from_app_focus
        super().set_focus(widget, scroll_visible, from_app_focus)
        if comes and isinstance(widget, Field):
            widget.action_select_all()

    def get_widget_and_offset_at(self, x: int, y: int) -> tuple[Widget | None, Offset | None]:
        """The widget there, and the place in its text; None and None where there is none.

        A toast that was clicked away, or a dialog's part, is drawn a moment longer than it lives;
        Textual would begin a selection within its parent, which is None then.
        """
        widget, offset = super().get_widget_and_offset_at(x, y)
        gone = widget is not None and widget is not self and widget.parent is None
        return (None, None) if gone else (widget, offset)
