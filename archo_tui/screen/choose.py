"""The dialog with a list to choose from, which typing narrows."""

from __future__ import annotations

import re
from collections.abc import Callable, Coroutine, Iterable, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

from rich.cells import cell_len
from rich.style import Style
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.content import Content
from textual.strip import Strip

from archo_tui.base.safe_text import harmless
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.terminal.app import COMMANDS
from archo_tui.screen.widgets.field import Field
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.rows import Rows
from archo_tui.text.columns import QUIET, Columns, Text, column, crop, fit_columns, in_columns

_LIT = Style(bold=True, underline=True)  # Of what a typed text matches, with any colours.


class Choice(NamedTuple):
    """A row of the list."""

    title: str  # What choosing it does.
    # Called after the dialog has closed; a coroutine is run as a command.
    act: Callable[[], Coroutine[Any, Any, None] | None]
    beside: str = ""  # At the right of the title: a key, a type.
    reason: str = ""  # Why it cannot be done now; the row can be chosen all the same.
    words: str = ""  # Other words that people may type for it.


class Fit(IntEnum):
    """The fit of a typed word to a choice; a smaller value is a better fit."""

    WORD = 0  # A whole word of the title, or of the other words.
    BEGINNING = 1  # The beginning of one.
    INSIDE = 2  # Any part of the title.
    NONE = 3


def fit(typed: str, title: str, others: str = "") -> Fit:
    """Return how well a casefolded word fits a title, or other words for it."""
    title = title.casefold()
    text, begin = f"{title} {others.casefold()}", rf"(?<![^\W_]){re.escape(typed)}"
    if re.search(rf"{begin}(?![^\W_])", text):
        return Fit.WORD
    if re.search(begin, text):
        return Fit.BEGINNING
    return Fit.INSIDE if typed in title else Fit.NONE


def matching(typed: str, choices: Iterable[Choice]) -> list[Choice]:
    """Return the choices that every typed word fits, in any order of the words, the best first."""
    ranked = []
    for choice in choices:
        fits = [fit(word, choice.title, choice.words) for word in typed.casefold().split()]
        if Fit.NONE not in fits:
            ranked.append(((max(fits, default=0), sum(fits)), choice))
    return [choice for _, choice in sorted(ranked, key=lambda found: found[0])]


def matched_spans(typed: str, title: str) -> list[tuple[int, int]]:
    """Return the sorted spans of what typed words match in a title; they may overlap.

    Empty if casefolding changes the title's length.
    """
    lower, found = title.casefold(), []
    if len(lower) != len(title):  # Its letters stand elsewhere.
        return []
    for word in typed.casefold().split():
        begins = re.search(rf"(?<![^\W_]){re.escape(word)}", lower)
        at = lower.find(word) if begins is None else begins.start()
        if at >= 0:
            found.append((at, at + len(word)))
    return sorted(found)


def _with_harmless_titles(choices: Sequence[Choice]) -> list[Choice]:
    return [choice._replace(title=harmless(choice.title)) for choice in choices]


def _columns(choices: Sequence[Choice], width: int) -> Columns:
    """Return the cells of titles, of the texts beside them, half at most, and of reasons."""
    beside = column((choice.beside for choice in choices), 0, width // 2)
    title = column((choice.title for choice in choices), 1, width)
    return fit_columns(((1, title), (beside, beside), (1, width)), width, (1, 0, 2))


def _lines(choice: Choice, _width: int, columns: Columns) -> list[Text]:
    """Return one line: `Release the stop (asks first)   R      the robot is not stopped`."""
    title, _, reason = columns
    texts = crop(choice.title, title), choice.beside, crop(choice.reason, reason)
    return [(in_columns(texts, columns, (2,)), QUIET if choice.reason else "")]


class ChoiceRows(Rows[Choice]):
    """The rows of the list, with a visible cursor though the field keeps the focus."""

    can_focus = False
    without_focus = True
    typed = ""  # Its matches in the titles are bold and underlined.

    def highlight(self, typed: str) -> None:
        """Highlight what a typed text matches in the titles, in place of the text before."""
        if typed != self.typed:
            self.typed = typed
            self.refresh()

    def render_line(self, y: int) -> Strip:
        strip, number = super().render_line(y), self.scroll_offset.y + y
        if not self.typed or number >= len(self.items):
            return strip
        title = crop(self.items[number].title, self.columns[0])
        for span in matched_spans(self.typed, title):
            begin, end = (cell_len(title[:place]) for place in span)
            before, lit, behind = strip.divide([begin, end, strip.cell_length])
            strip = Strip.join([before, lit.apply_style(_LIT), behind])
        return strip


class Choose(Dialog):
    """A dialog with a list, and a field that narrows it by typing."""

    closes_at_stop = True
    empty_text = "nothing matches"

    BINDINGS = [
        ("escape", "close", "Close"),
        *(Binding(key, f"turn('{key}')", show=False) for key in ("pageup", "pagedown")),
    ]

    def __init__(self, title: str, choices: Sequence[Choice]) -> None:
        super().__init__()
        self.title, self._all = title, _with_harmless_titles(choices)
        self._narrow = Field(
            id="narrow",
            placeholder="type a part of its name",
            changed=self._show_matches,
            submitted=self.action_choose,
            stepped=self._step,
        )
        self._rows = ChoiceRows(
            _lines,
            lambda choice: choice,
            id="choices",
            empty=self.empty_text,
            action="screen.choose",
            columns=_columns,
        )
        self._count = Line(classes="count")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog choosing") as box:
            box.styles.height = max(len(self._all), 1) + 4  # Border, field and count.
            box.border_title = self.title
            box.border_subtitle = "type to narrow   ↑ ↓, enter   esc cancel"
            yield self._narrow
            yield self._rows
            yield self._count

    def on_mount(self) -> None:
        self.set_focus(self._narrow)
        self._show_matches()

    def _matches(self) -> Sequence[Choice]:
        """Return the choices that match the typed text, the best first; all if nothing is typed."""
        return matching(self._narrow.value, self._all)

    def _show_matches(self) -> None:
        shown = self._matches()
        self._rows.highlight(self._narrow.value)
        self._rows.show(shown)
        self._rows.move_to(0)
        self._show_reason()

    def _show_reason(self) -> None:
        """Show below the list how many rows match, and why the selected one cannot be done now."""
        choice, shown = self._rows.item, len(self._rows.items)
        reason = f"   not now: {choice.reason}" if choice is not None and choice.reason else ""
        self._count.show(Content.styled(f"{shown} of {len(self._all)}{reason}", "$quiet"))

    def update_choices(self, choices: Sequence[Choice]) -> None:
        """Replace each row by the new choice with the same title; new titles are not added."""
        by_title = {choice.title: choice for choice in _with_harmless_titles(choices)}
        self._all = [by_title.get(choice.title, choice) for choice in self._all]
        self._rows.show(self._matches())
        self._show_reason()

    def on_click(self, event: events.Click) -> None:
        if event.widget in (self, *self.query("DialogHead, DialogHead Line")):  # Beside the box.
            self.dismiss()

    def action_choose(self) -> None:
        """Close the dialog and do what the selected row is for."""
        choice = self._rows.item
        if choice is None or not self.is_current:
            return
        self.dismiss()
        work = choice.act()
        if work is not None:
            self.app.run_worker(work, group=COMMANDS)

    def _step(self, step: int) -> None:
        self._rows.move_to(self._rows.cursor + step)
        self._show_reason()

    def action_turn(self, key: str) -> None:
        """Move the cursor by a page, for `pageup` or `pagedown`."""
        self._rows.action_press(key)
        self._show_reason()
