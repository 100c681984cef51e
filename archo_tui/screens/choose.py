"""A list to choose from: type to narrow it, enter or a click takes a row."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from typing import Any, NamedTuple

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.content import Content

from archo_tui.robot.text import harmless
from archo_tui.screens.dialog import Dialog
from archo_tui.screens.find import found
from archo_tui.terminal.app import COMMANDS
from archo_tui.widgets.field import Field
from archo_tui.widgets.line import Line
from archo_tui.widgets.rows import QUIET, Columns, Rows, Text, column, crop, pad

_REASON = 30  # cells at the right that are worth having


class Choice(NamedTuple):
    """A row, and what is done when it is taken; a coroutine may wait for the robot."""

    title: str
    act: Callable[[], Coroutine[Any, Any, None] | None]
    beside: str = ""  # a key, a type
    reason: str = ""  # why it cannot be done now
    words: str = ""  # others that people type for it


def _harmless(choices: Sequence[Choice]) -> list[Choice]:
    return [one._replace(title=harmless(one.title)) for one in choices]


def _columns(choices: Sequence[Choice], width: int) -> Columns:
    """Of titles and what is beside them."""
    beside = column((one.beside for one in choices), 0, width // 2)
    room = width - beside - 2
    with_reason = room - _REASON - 2 if any(one.reason for one in choices) else room
    return column((one.title for one in choices), 1, max(with_reason, 1)), beside


def _lines(choice: Choice, width: int, columns: Columns) -> list[Text]:
    """`Release the stop (asks first)   R   the robot is not stopped`."""
    title, beside = columns
    text = f"{pad(crop(choice.title, title), title)}  {pad(choice.beside, beside)}"
    room = width - title - beside - 4
    if choice.reason and room > 0:
        text += f"  {crop(choice.reason, room):>{room}}"
    return [(text.rstrip(), QUIET if choice.reason else "")]


class Found(Rows[Choice]):
    """The rows; keys stay in the field, where is typed what narrows them."""

    can_focus = False
    without_focus = True
    taken: Callable[[], object]  # called when a row was clicked

    async def on_click(self, event: events.Click) -> None:
        row = self.scroll_offset.y + event.y
        if 0 <= row < len(self.items):
            self.to(row)
            self.taken()

    def to(self, number: int) -> None:
        """The cursor is there."""
        self._move(number - self.cursor)


class Choose(Dialog[None]):
    """Escape chooses nothing."""

    closes_at_stop = True
    nothing = "nothing matches"

    BINDINGS = [
        ("escape", "close", "Close"),
        *(Binding(key, f"turn('{key}')", show=False) for key in ("pageup", "pagedown")),
    ]

    def __init__(self, title: str, choices: Sequence[Choice]) -> None:
        super().__init__()
        self.title, self._all = title, _harmless(choices)
        self._narrow = Field(
            id="narrow",
            placeholder="type a part of its name",
            changed=self._fill,
            submitted=self._take,
            stepped=self._step,
        )
        self._rows = Found(
            _lines, lambda one: one, id="choices", empty=self.nothing, columns=_columns
        )
        self._rows.taken = self._take
        self._count = Line(classes="count")

    def body(self) -> ComposeResult:
        with Vertical(classes="dialog choosing") as box:
            box.styles.height = max(len(self._all), 1) + 5  # its border, field and count
            box.border_title = self.title
            box.border_subtitle = "type to narrow   ↑ ↓, enter   esc cancel"
            yield self._narrow
            yield self._rows
            yield self._count

    def on_mount(self) -> None:
        self.set_focus(self._narrow)
        self._fill()

    def _found(self) -> Sequence[Choice]:
        return found(self._narrow.value, self._all, lambda one: (one.title, one.words))

    def _fill(self) -> None:
        shown = self._found()
        self._rows.show(shown)
        self._rows.to(0)
        self._count.show(Content.styled(f"{len(shown)} of {len(self._all)}", "$quiet"))

    def renew(self, choices: Sequence[Choice]) -> None:
        """Replace each row by the choice of that title; none moves, comes or goes."""
        now = {one.title: one for one in _harmless(choices)}
        self._all = [now.get(one.title, one) for one in self._all]
        self._rows.show(self._found())

    def on_click(self, event: events.Click) -> None:
        if event.widget is self:  # beside the dialog
            self.dismiss()

    def _take(self) -> None:
        choice = self._rows.item
        if choice is None or not self.is_current:
            return
        self.dismiss()
        work = choice.act()
        if work is not None:
            self.app.run_worker(work, group=COMMANDS)

    def _step(self, step: int) -> None:
        self._rows.to(self._rows.cursor + step)

    def action_turn(self, key: str) -> None:
        """By what is seen."""
        self._rows.action_press(key)
