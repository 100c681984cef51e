"""The commands of the History panel."""

from __future__ import annotations

from archo_tui.commands.base import Command, Desk


class ShowHistory(Command):
    id, key, verbs = "history", "h", ("history",)
    help = "Show the history on the full screen, or leave it"

    def run(self, desk: Desk) -> None:
        desk.main.toggle_full(desk.main.history)


class ChangeSpan(Command):
    """A command that shows the next longer (1) or shorter (-1) time span of the history."""

    def __init__(self, by: int) -> None:
        self._by = by
        self._word, self._most = ("longer", "longest") if by > 0 else ("shorter", "shortest")
        self.id = self._word
        self.key = "right_square_bracket" if by > 0 else "left_square_bracket"
        self.help = f"Show a {self._word} time in the history: 1 min, 10 min or an hour"

    def disabled_reason(self, desk: Desk) -> str:
        history = desk.main.history
        if not history.display:
            return f"the history is not shown: press {desk.view.key('history')}"
        return "" if history.can_change_span(self._by) else f"already the {self._most} span"

    def run(self, desk: Desk) -> None:
        desk.main.history.change_span(self._by)
        desk.update_screen()
