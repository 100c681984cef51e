"""Panel 3: give the robot a goal, see what becomes of it, cancel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widget import Widget
from textual.widgets import Static

from archo_tui.robot.forms import is_integer, is_number, parse
from archo_tui.robot.state import WATCHING, Leaf, Snapshot
from archo_tui.station.reason import Reason, limits, obstacles
from archo_tui.widgets.board import Board
from archo_tui.widgets.button import Button
from archo_tui.widgets.field import INTEGER, NUMBER, Field
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.shown import Shown
from archo_tui.words import board as boards
from archo_tui.words.goal import goal_history, goal_line, goal_strip, keys_to_press
from archo_tui.words.state import BAD

_WIDE, _HIGH = 150, 40  # cells and rows of a terminal from which on it has room for the board
_ELSEWHERE, _LEAST_ROWS = 28, 4  # rows that all else needs; of the board at least
_EVENTS = 10  # of them the events'; in three columns they have a third of all
_IN_FIELD = ("go", "go"), ("cancel", "cancel")
_ON_BOARD = _IN_FIELD[1:]  # where enter types, and sends nothing
_LINES = 6  # of this panel without the board, its border included


class GoalPanel(Panel):
    """A form, a bar, where the goal stands, and the goals before."""

    number, title_text = 3, "Goal"
    shown_as = {"go": "enter"}
    _watching = False
    _reason: Reason | None = None  # of what the hint says; None: it is about what was typed only

    # called with the values of each goal by dotted path, to be sent in their order, and with what
    # was typed for them
    send: Callable[[Sequence[Mapping[str, Any]], list[str]], object]

    def __init__(self, snapshot: Snapshot) -> None:
        """`snapshot` knows the robot's file, and what the fields of its forms take."""
        self._snapshot = snapshot
        self._kind = snapshot.file.goals[0] if snapshot.file.goals else None
        if self._kind is not None:
            self.title_text = self._kind.title
        super().__init__()
        form = {} if self._kind is None else self._kind.form
        self._leaves = () if self._kind is None else snapshot.forms.get(self._kind.id, ())
        self.fields = [
            Field(
                id=f"goal-{number}",
                takes=_takes(leaf),
                changed=self.hint,
                submitted=self.submit,
                stepped=self._recall,
                refused=self.hint,
            )
            for number, leaf in enumerate(self._leaves)
        ]
        for field, following in zip(self.fields, self.fields[1:], strict=False):
            field.next_field = following
        units = [(given.label or path, given.unit) for path, given in form.items()]
        self._labels = [f"{label} ({unit}) " if unit else f"{label} " for label, unit in units]
        self._go = Button("Go", self.submit, id="go")
        self._cancel = Button("Cancel", "cancel", id="cancel")
        self.typed: list[list[str]] = []  # what was sent
        self._place, self._draft = 0, [""] * len(self.fields)
        self._hint, self._bar = Line(id="goal-hint"), Line(id="goal-bar")
        self._line, self._history = Line(id="goal-line"), Line(id="goal-history")
        self.board = Board(self._take, self._on_board)
        self._boarded: object = None  # what is on it was made of that
        self._has_board = False  # the robot file and the robot say what is on it
        self._height: int | None = None

    def compose(self) -> ComposeResult:
        with Horizontal(classes="buttons"):
            for label, field in zip(self._labels, self.fields, strict=False):
                yield Static(label, classes="label", markup=False)
                yield field
            yield from (self._go, self._cancel)
            if not self._is_wide:
                yield self._hint
        yield self._bar
        if self._is_wide:
            yield self._hint
        yield from (self._line, self.board, self._history)

    @property
    def _is_wide(self) -> bool:
        """True when the form leaves no room beside it: what is wrong covers the goal's line."""
        return len(self.fields) > 1

    def on_mount(self) -> None:
        if self._is_wide:
            self._hint.display = False

    def show(self, view: Shown) -> None:
        snapshot, self._watching = view.snapshot, view.watching
        self._snapshot = snapshot
        width = self._bar.size.width
        self._show_board(view, width)
        self.keys = _ON_BOARD if self.board.has_focus else _IN_FIELD
        self.show_keys(view, *self._word_here)
        self._bar.say(goal_strip(snapshot.goal, width))
        go = view.key("go")
        ask = keys_to_press(self._kind, go) if self._kind and not view.watching else ""
        self._line.say(goal_line(snapshot, view.now, ask, width))
        ways = ("continue", "skip")
        keys = "   ".join(f"{view.key(name)} {name}" for name in ways if view.key(name))
        before = goal_history(snapshot.history, width, view.waiting, view.held, keys)
        self._history.say(before)
        self.grey(view, [("" if self._kind is None else self._kind.action, self._go)])
        nothing = snapshot.goal is None and self._go.has_class("-blocked")
        self._cancel.set_class(view.watching or nothing, "-blocked")
        if self._reason is not None and self._reason.is_over(snapshot):
            self.hint("")

    def _show_board(self, view: Shown, width: int) -> None:
        """Where there is room for it, and over the panels below while it has the focus."""
        snapshot, kind, size = view.snapshot, self._kind, self.app.size
        goal = None if snapshot.goal is None else (snapshot.goal.number, snapshot.goal.phase)
        limits = snapshot.namespace, snapshot.parameters, snapshot.forms
        boarded = limits, goal, snapshot.history, view.queue, width, size
        if boarded != self._boarded:  # readings and feedback change nothing on it
            self._boarded = boarded
            numbers = None if kind is None else boards.selectable_numbers(snapshot, kind)
            self._has_board = numbers is not None and width > 0
            if kind is not None and numbers is not None and width > 0:
                events = max(size.height // 3 - _EVENTS, 0) if size.width >= _WIDE else 0
                rows = max(size.height - _ELSEWHERE - events, _LEAST_ROWS)
                marks = boards.marks(snapshot, kind, view.queue)
                self.board.show(boards.fit_grid(numbers, width, rows), marks)
        self._unfold()

    def _unfold(self) -> None:
        size, is_focused = self.app.size, self.board is self.screen.focused
        if is_focused and not self._has_board:  # the robot says no more what is on it
            self.type_on()
        has_room = size.width >= _WIDE or size.height >= _HIGH
        seen = self._has_board and (has_room or is_focused)
        self.board.display = seen
        height = _LINES + self.board.rows if seen else None
        if height != self._height:  # a height of None lays the screen out anew each time
            self._height = self.styles.height = height

    @property
    def _word_here(self) -> tuple[str, str]:
        """What the border says of the board: a word, and its key."""
        if self.board.has_focus:
            return "takes it into the field", "enter"
        folded = self._has_board and not self.board.display and not self.can_focus
        return ("board", "tab") if folded else ("", "")

    def _on_board(self) -> None:
        """The focus came to the board, or left it."""
        self._unfold()
        self.post_message(self.Resized(self))
        if self.board.has_focus:  # in a tiny terminal what it grew by is out of sight
            self.call_after_refresh(self.scroll_visible, animate=False)

    def only_show(self) -> None:
        """Nothing is typed here, and nothing sent."""
        self.can_focus, self.board.can_focus, self.board.disabled = True, False, True

    def _take(self, number: int) -> None:
        """A number was chosen: it is typed, and enter in the field sends it."""
        self.type_on()
        self.fields[0].choose(str(number))

    def type_on(self) -> None:
        """From the board back to the field, where what was typed is not selected: it stays."""
        self.screen.set_focus(self.fields[0], scroll_visible=False, from_app_focus=True)

    def beside(self, widget: Widget | None, step: int) -> Widget | None:
        """What tab (1) or shift+tab (-1) leads to, from field to board to Go; None: elsewhere."""
        if not self._has_board or self.can_focus:
            return None
        order = (self.fields[0], self.board, self._go)
        places = {one: place for place, one in enumerate(order)}
        place = places.get(widget, -9) + step if widget is not None else -9
        return order[place] if 0 <= place < len(order) else None

    @property
    def operated(self) -> Widget:
        """The first field; the button where there is none."""
        return self.fields[0] if self.fields else self._go

    def _recall(self, step: int) -> None:
        """Show what was sent before (-1), or after that (1); at last what stood there."""
        if self._place == len(self.typed):
            self._draft = [field.value for field in self.fields]
        self._place = min(max(self._place + step, 0), len(self.typed))
        behind = self._place == len(self.typed)
        for field, text in zip(
            self.fields, self._draft if behind else self.typed[self._place], strict=False
        ):
            field.fill(text)

    def recalls(self, typed: list[list[str]]) -> None:
        """What was sent, the oldest first."""
        self.typed, self._place = typed, len(typed)

    def hint(self, text: str = "", reason: Reason | None = None) -> None:
        """Show why a goal is not sent or driven, until what was typed changes.

        Args:
            text: The words; empty: nothing is in the way.
            reason: Takes the words away as soon as it is over.
        """
        self._reason = reason
        if reason is not None:
            reason.is_over(self._snapshot)  # notes what holds now
        if self._is_wide:
            self._hint.display, self._line.display = text != "", text == ""
        self._hint.say(((text, BAD),))

    def answer(self, text: str) -> None:
        """Show why the robot does not go there, while that may be so."""
        self.hint(text, Reason(obstacles))

    def submit(self) -> None:
        """Ask for what was typed, or say what is wrong with it; nothing asks for nothing."""
        typed = [field.value for field in self.fields]
        if self._kind is None:
            self.hint(f"{self.app.title}: the robot file names no goal")
            return
        if self._watching:
            self.hint(WATCHING)
            return
        if self.fields and not any(text.strip() for text in typed):
            return
        several = len(self._leaves) == 1 and is_number(self._leaves[0])
        rows = [[word] for word in typed[0].split()] if several else [typed]
        goals, form = [], self._snapshot.form(self._kind)
        for row in rows:
            values: dict[str, Any] = {}
            for leaf, field, text in zip(self._leaves, self.fields, row, strict=True):
                try:
                    values[leaf.path] = parse(leaf, form[leaf.path], text)
                except ValueError as error:
                    self.hint(str(error), Reason(limits))
                    self.screen.set_focus(field)
                    return
            goals.append(values)
        self.hint("")
        for field in self.fields:
            field.clear()
        if self.fields:
            self.screen.set_focus(self.fields[0])
        self.send(goals, typed)


def _takes(leaf: Leaf) -> str:
    if is_integer(leaf):
        return INTEGER
    return NUMBER if is_number(leaf) else ""
