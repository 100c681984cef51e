"""The one kind of button: a line high."""

from __future__ import annotations

from textual import widgets


class Button(widgets.Button, inherit_css=False):
    """Textual's, without its fifty-seven rules: every style that is looked up asks them all."""

    DEFAULT_CSS = """
        Button {
            width: auto; min-width: 16; height: 1; line-pad: 1; text-align: center;
            content-align: center middle; pointer: pointer;
        }
        Button:focus { background-tint: $foreground 5%; }
        Button:disabled { text-opacity: 0.6; pointer: not-allowed; }
        Button.-active { tint: $background 30%; }
    """
