"""A numbered panel with its title above and its keys below."""

from __future__ import annotations

from textual.containers import Container

from archo_tui.widgets.view import View


class Panel(Container):
    """Base of the six panels; `show` gets every new view."""

    number = 0
    title_text = ""
    keys = ""

    def __init__(self) -> None:
        super().__init__(id=f"panel-{self.number}", classes="panel")
        self.border_title = f"{self.number} {self.title_text}"
        self.border_subtitle = self.keys

    def show(self, view: View) -> None:
        """Show what changed."""
        raise NotImplementedError

    def grey(self, view: View, **buttons: str) -> None:
        """Dim each button whose service nobody offers; pressing it still says so."""
        for button, service in buttons.items():
            missing = service not in view.snapshot.offered
            self.query_one(f"#{button}").set_class(missing, "-blocked")

    def take_focus(self) -> None:
        """Focus what a person expects to operate in this panel, at once: keys may follow."""
        self.screen.set_focus(self)
