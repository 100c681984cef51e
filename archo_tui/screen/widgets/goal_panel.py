"""The panel of the goal: the form for a goal, the goal's progress, and the goals before."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widget import Widget
from textual.widgets import Static

from archo_tui.robot.messages.typed import FieldError, is_integer, is_number, parse_all
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import WATCHING
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.screen.widgets.field import INTEGER, NUMBER, Button, Field
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.panel import Panel, ScreenState
from archo_tui.text.goal import goal_history, goal_line, goal_strip, keys_to_press
from archo_tui.text.state import BAD

_RECALLED = 50  # Goals that the arrows recall.


class GoalPanel(Panel):
    """The panel with the form, the progress, the goal's state, and the goals before."""

    title_text, place = "Goal", "right"
    keys = ("go", "go"), ("cancel", "cancel")
    other_keys = {"go": "enter"}
    _watching = False
    _shows_refusal = False  # Of the robot.

    # Called with the values of each goal by dotted path, in the order of sending. Set by the owner,
    # as `on_typed`.
    send: Callable[[Sequence[Mapping[str, Any]]], object]
    on_typed: Callable[[], object]  # Called after the text of a field has changed.

    @classmethod
    def title_for(cls, robot: RobotFile) -> str:
        return robot.goals[0].title if robot.goals else cls.title_text

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self._snapshot = snapshot
        self._kind = snapshot.file.goals[0] if snapshot.file.goals else None
        if self._kind is not None and self._kind.remaining is not None:
            self.add_class("-way")  # The bar has three rows where there is room.
        form = {} if self._kind is None else self._kind.form
        self._message_fields = () if self._kind is None else snapshot.forms.get(self._kind.id, ())
        self.fields = [  # Empty without a goal, or if its type is not installed.
            Field(
                id=f"goal-{number}",
                takes=_allowed_characters(message_field),
                changed=self._on_changed,
                submitted=self.submit,
                stepped=self._recall_typed,
                refused=self.show_hint,
            )
            for number, message_field in enumerate(self._message_fields)
        ]
        for field, following in zip(self.fields, self.fields[1:], strict=False):
            field.next_field = following
        for field in self.fields:
            does = "Next field" if field.next_field else "Go"
            field.keys = ("enter", does), ("↑ ↓", "Recent goals"), ("esc", "Leave")
        units = [(given.label or path, given.unit) for path, given in form.items()]
        self._labels = [f"{label} ({unit}) " if unit else f"{label} " for label, unit in units]
        self._go = Button("Go", self.submit, id="go")
        self._cancel = Button("Cancel", "cancel", id="cancel")
        # The goals that the arrows recall, the oldest first: a text for each field.
        self.typed: list[list[str]] = []
        self._typed_index, self._unsent = 0, [""] * len(self.fields)
        self._hint, self._bar = Line(id="goal-hint"), Line(id="goal-bar")
        self._line, self._history = Line(id="goal-line"), Line(id="goal-history")

    def compose(self) -> ComposeResult:
        with Horizontal(classes="buttons"):
            for label, field in zip(self._labels, self.fields, strict=False):
                yield Static(label, classes="label", markup=False)
                yield field
            yield from (self._go, self._cancel)
            if not self._has_several_fields:
                yield self._hint
        yield self._bar
        if self._has_several_fields:
            yield self._hint
        yield from (self._line, self._history)

    @property
    def _has_several_fields(self) -> bool:
        return len(self.fields) > 1

    def on_mount(self) -> None:
        if self._has_several_fields:
            self._hint.display = False

    def show(self, view: ScreenState) -> None:
        snapshot, self._watching = view.snapshot, view.watching
        self._snapshot = snapshot
        width, rows = self._bar.size
        self.show_keys(view)
        self._bar.show_spans(*goal_strip(snapshot.goal, width, rows))
        go = "" if self.focused_field else view.key("go")
        ask = keys_to_press(self._kind, go) if self._kind and not view.watching else ""
        line = goal_line(snapshot, view.now, ask, width)
        self._line.show_spans(line)
        ways = ("continue", "skip")
        keys = "   ".join(f"{view.key_to_press(name)} {name}" for name in ways if view.key(name))
        before = goal_history(snapshot.history, width, view.waiting, view.held, keys)
        self._history.show_spans(before)
        self.dim_unavailable(view, [("" if self._kind is None else self._kind.action, self._go)])
        nothing = snapshot.goal is None and self._go.has_class("-blocked")
        self._cancel.set_class(view.watching or nothing, "-blocked")

    @property
    def focused_field(self) -> Field | None:
        """Return the field that has the focus; None if none has."""
        return next((field for field in self.fields if field is self.screen.focused), None)

    @property
    def field_keys(self) -> Sequence[tuple[str, str]]:  # type: ignore[override]
        return self.focused_field.keys if self.focused_field is not None else ()

    @property
    def first_field(self) -> Field | None:
        """Return the first field if a letter typed into it now would be a command; None else."""
        field = self.fields[0] if self.fields else None
        return None if field is None or field.is_text("q") else field

    @property
    def focus_target(self) -> Widget:
        """Return the first field; the Go button if the form has no fields."""
        return self.fields[0] if self.fields else self._go

    def _recall_typed(self, step: int) -> None:
        """Fill in the texts of the goal sent before (-1) or after (1) the one in the form."""
        if self._typed_index == len(self.typed):
            self._unsent = [field.value for field in self.fields]
        self._typed_index = min(max(self._typed_index + step, 0), len(self.typed))
        behind = self._typed_index == len(self.typed)
        for field, text in zip(
            self.fields, self._unsent if behind else self.typed[self._typed_index], strict=False
        ):
            field.fill(text)

    def _on_changed(self) -> None:
        """Remove the hint, call `on_typed`, and scroll the panel into view if a field has text."""
        self.show_hint()
        self.on_typed()
        if any(field.value for field in self.fields):
            self.scroll_visible(animate=False)

    def show_hint(self, text: str = "") -> None:
        """Show why a goal is not sent, until the next key; "" removes it."""
        self._shows_refusal = False
        if self._has_several_fields:
            self._hint.display, self._line.display = text != "", text == ""
        self._hint.show_spans(((text, BAD),))

    def show_refusal(self, text: str) -> None:
        """Show why the robot refuses a goal, until the next key.

        "" removes the refusal that is shown, but no hint about what is typed.
        """
        if text or self._shows_refusal:
            self.show_hint(text)
            self._shows_refusal = text != ""

    def submit(self) -> None:
        """Send the typed goals and clear the form, or show what is wrong and keep it."""
        typed = [field.value for field in self.fields]
        if self._kind is None:
            self.show_hint(f"{self.app.title}: the robot file names no goal")
            return
        if self._watching:
            self.show_hint(WATCHING)
            return
        if self.fields and not any(text.strip() for text in typed):
            return
        try:
            goals = self._parse(self._kind, typed)
        except FieldError as error:
            self.show_hint(str(error))
            paths = [message_field.path for message_field in self._message_fields]
            self.screen.set_focus(self.fields[paths.index(error.path)])
            return
        self.show_hint("")
        for field in self.fields:
            field.clear()
        if self.fields:
            self.screen.set_focus(self.fields[0])
        self.typed = [*[old for old in self.typed if old != typed], typed][-_RECALLED:]
        self._typed_index = len(self.typed)
        self.send(goals)

    def _parse(self, kind: GoalKind, typed: list[str]) -> list[dict[str, Any]]:
        """Return the values of each goal by dotted path; FieldError for a wrong text."""
        # A line may have several goals if a goal is a single number.
        takes_several = len(self.fields) == 1 and is_number(self._message_fields[0])
        rows = [[word] for word in typed[0].split()] if takes_several else [typed]
        form, paths = self._snapshot.form(kind), [field.path for field in self._message_fields]
        texts = (dict(zip(paths, row, strict=True)) for row in rows)
        return [parse_all(self._message_fields, form, of_goal) for of_goal in texts]


def _allowed_characters(message_field: TypedField) -> str:
    if is_integer(message_field):
        return INTEGER
    return NUMBER if is_number(message_field) else ""
