"""The base of widgets that are not redrawn when the focus comes or goes."""

from __future__ import annotations

from textual import events
from textual.widget import Widget


class QuietFocus(Widget):
    """A widget that Textual does not redraw when it gets or loses the focus.

    A subclass redraws what changes in `watch_has_focus`. List it last among the bases.
    """

    def on_focus(self, event: events.Focus) -> None:
        event.prevent_default()  # Textual would redraw the widget and its children.
        self.has_focus = True

    def on_blur(self, event: events.Blur) -> None:
        event.prevent_default()
        self.has_focus = False
