"""A widget that is not drawn anew because the focus comes or goes."""

from __future__ import annotations

from textual import events
from textual.widget import Widget


class QuietFocus(Widget):
    """Base of those whose `watch_has_focus` draws what changes; the last one, as ByLines."""

    def on_focus(self, event: events.Focus) -> None:
        event.prevent_default()  # Textual draws all of it, and all that it contains
        self.has_focus = True

    def on_blur(self, event: events.Blur) -> None:
        event.prevent_default()
        self.has_focus = False
