"""What all dialogs have: they end once, however often their keys are pressed."""

from __future__ import annotations

from textual.screen import ModalScreen, ScreenResultType


class Dialog(ModalScreen[ScreenResultType]):
    """Base of the dialogs."""

    def end(self, result: ScreenResultType | None = None) -> None:
        """Close with a result. A second enter, or an answer that comes late, changes nothing."""
        if self.is_current:
            self.dismiss(result)
