"""Panel 3: give the robot a goal, see what becomes of it, cancel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Button, Label

from archo_tui import goal_text, state_text
from archo_tui.robot.forms import is_integer, is_number, parse
from archo_tui.robot.state import WATCHING, Leaf, Phase, Snapshot
from archo_tui.targets import Target
from archo_tui.widgets.field import INTEGER, NUMBER, Field
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.shown import Shown
from archo_tui.widgets.styled import content


class GoalPanel(Panel):
    """A form, a bar, where the goal stands, and the goals before."""

    number, title_text = 3, "Goal"
    keys = (("cancel", "cancel"),)
    _watching = False
    _about: object = None  # what the robot's answer that is shown was about

    class Send(Message):
        """The operator wants the robot to do that, one after the other."""

        def __init__(self, targets: Sequence[Target], typed: Sequence[str]) -> None:
            super().__init__()
            self.targets, self.typed = targets, list(typed)

    def __init__(self, snapshot: Snapshot) -> None:
        """`snapshot` knows the robot's file, and what the fields of its forms take."""
        self._kind = snapshot.robot.goals[0] if snapshot.robot.goals else None
        if self._kind is not None:
            self.title_text = self._kind.title
        super().__init__()
        form = {} if self._kind is None else self._kind.form
        self._leaves = () if self._kind is None else snapshot.forms.get(self._kind.id, ())
        self.fields = [
            Field(id=f"goal-{number}", takes=_takes(leaf))
            for number, leaf in enumerate(self._leaves)
        ]
        for field, following in zip(self.fields, self.fields[1:], strict=False):
            field.next_field = following
        units = [(given.label or path, given.unit) for path, given in form.items()]
        self._labels = [f"{label} ({unit}) " if unit else f"{label} " for label, unit in units]
        self._go = Button("Go", id="go", compact=True)
        self._cancel = Button("Cancel", id="cancel", compact=True, action="app.command('cancel')")
        self.typed: list[list[str]] = []  # what was sent
        self._place, self._draft = 0, [""] * len(self.fields)
        self._hint, self._bar = Line(id="goal-hint"), Line(id="goal-bar")
        self._line, self._history = Line(id="goal-line"), Line(id="goal-history")

    def compose(self) -> ComposeResult:
        with Horizontal(classes="buttons"):
            for label, field in zip(self._labels, self.fields, strict=False):
                yield Label(label)
                yield field
            yield from (self._go, self._cancel)
            if not self._is_wide:
                yield self._hint
        yield self._bar
        if self._is_wide:
            yield self._hint
        yield from (self._line, self._history)

    @property
    def _is_wide(self) -> bool:
        """True when the form leaves no room beside it: what is wrong covers the goal's line."""
        return len(self.fields) > 1

    def on_mount(self) -> None:
        if self._is_wide:
            self._hint.display = False

    def show(self, view: Shown) -> None:
        self.show_keys(view, "enter go")
        snapshot, self._watching = view.snapshot, view.watching
        width = self._bar.size.width
        self._bar.show(content(goal_text.goal_strip(snapshot.goal, width)))
        go = view.key("go")
        ask = "" if self._kind is None else goal_text.keys_to_press(self._kind, go)
        line = goal_text.goal_line(snapshot, view.now, ask)
        self._line.show(content(line))
        before = goal_text.goal_history(snapshot.history, width, view.waiting, view.held)
        self._history.show(content(before))
        self.grey(view, [("" if self._kind is None else self._kind.action, self._go)])
        self._cancel.set_class(snapshot.goal is None and self._go.has_class("-blocked"), "-blocked")
        if self._about not in (None, _situation(snapshot)):
            self.hint("")

    @property
    def operated(self) -> Widget:
        """The first field; the button where there is none."""
        return self.fields[0] if self.fields else self._go

    def on_input_changed(self) -> None:
        self.hint("")

    def on_input_submitted(self, event: Field.Submitted) -> None:
        assert isinstance(event.input, Field)
        # the last one as it was: the keys behind enter may have changed it since
        behind = event.input.value.removeprefix(event.value)
        self.submit([*(field.value for field in self.fields[:-1]), event.value], behind)
        event.input.answered()

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "go":
            self.submit([field.value for field in self.fields])

    def on_field_recall(self, event: Field.Recall) -> None:
        """Show what was sent before, or after that; behind the last one what stood there."""
        if self._place == len(self.typed):
            self._draft = [field.value for field in self.fields]
        self._place = min(max(self._place + event.step, 0), len(self.typed))
        behind = self._place == len(self.typed)
        for field, text in zip(
            self.fields, self._draft if behind else self.typed[self._place], strict=False
        ):
            field.value = text
            field.cursor_position = len(text)

    def recalls(self, typed: list[list[str]]) -> None:
        """What was sent, the oldest first."""
        self.typed, self._place = typed, len(typed)

    def on_field_refused(self, event: Field.Refused) -> None:
        event.stop()
        self.hint(event.reason)

    def hint(self, text: str) -> None:
        """Say why what was typed cannot be sent."""
        self._about = None
        if self._is_wide:
            self._hint.display, self._line.display = text != "", text == ""
        self._hint.show(content(((text, state_text.BAD),)))

    def answer(self, text: str, snapshot: Snapshot) -> None:
        """Say why the robot does not go there, while that is so."""
        self.hint(text)
        self._about = _situation(snapshot)

    def submit(self, typed: Sequence[str], behind: str = "") -> None:
        """Ask for what was typed, or say what is wrong with it; nothing asks for nothing.

        `behind` was typed since, and is for the next time.
        """
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
        targets = []
        for row in rows:
            values: dict[str, Any] = {}
            for leaf, field, text in zip(self._leaves, self.fields, row, strict=True):
                try:
                    values[leaf.path] = parse(leaf, self._kind.form[leaf.path], text)
                except ValueError as error:
                    self.hint(str(error))
                    self.screen.set_focus(field)
                    return
            targets.append(Target(self._kind, values))
        self.hint("")
        for field in self.fields:
            field.clear()
        if self.fields:
            self.fields[0].value = behind
            self.fields[0].cursor_position = len(behind)
            self.screen.set_focus(self.fields[0])
        self.post_message(self.Send(targets, typed))


def _takes(leaf: Leaf) -> str:
    if is_integer(leaf):
        return INTEGER
    return NUMBER if is_number(leaf) else ""


def _situation(snapshot: Snapshot) -> object:
    """What a refusal may be about: another goal, one without news, nobody there to ask."""
    goal, actions = snapshot.goal, {kind.action for kind in snapshot.robot.goals}
    offered = actions & snapshot.offered
    if goal is None:
        return offered
    doubtful = goal.phase in (Phase.UNKNOWN, Phase.LOST)
    return offered, goal.sent, goal.is_running, doubtful
