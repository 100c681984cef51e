"""The commands of Graph: a topic, its fields live and plotted, a service, and the transforms."""

from __future__ import annotations

import asyncio
import textwrap
from collections.abc import Mapping, Sequence
from functools import partial

from textual.app import ComposeResult
from textual.containers import Vertical, VerticalScroll
from textual.content import Content
from textual.markup import escape
from textual.widgets import Static

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.definitions import definitions_text
from archo_tui.robot.state.graph import TOPIC, TopicInfo
from archo_tui.robot.topics.rows import (
    SHOWN_ELEMENTS,
    FieldKind,
    FieldView,
    TopicRequest,
    TopicView,
)
from archo_tui.ros.names import base_name
from archo_tui.screen.commands.base import IN_PANEL, Command, Desk
from archo_tui.screen.commands.generic import AnyTopic
from archo_tui.screen.dialog import HEAD_FROM, Dialog, ListDialog, ShowText
from archo_tui.screen.main import TALL, WIDE
from archo_tui.screen.terminal.app import COMMANDS, start_worker
from archo_tui.screen.widgets.field import Search
from archo_tui.screen.widgets.graph_panel import GraphPanel
from archo_tui.screen.widgets.line import Line, content
from archo_tui.screen.widgets.rows import Rows
from archo_tui.station.view import View
from archo_tui.text.columns import Columns, Text
from archo_tui.text.graph import topic_lines, transform_lines
from archo_tui.text.state import WARN, not_drawn
from archo_tui.text.topic import (
    curve_columns,
    field_columns,
    field_line,
    field_titles,
    plot_columns,
    summary,
    topic_plots,
)


class ShowResource(Command):
    in_replay = True
    id, key, where, panel = "resource", "enter", IN_PANEL, GraphPanel
    help = (
        "Show the selected topic, its fields live, with plots and QoS; "
        "of a service or an action its full type and its nodes"
    )
    verbs = ("echo", "hz", "interface")

    def disabled_reason(self, desk: Desk) -> str:
        return "" if desk.main.graph.selected else "nothing is selected"

    def run(self, desk: Desk) -> None:
        row = desk.main.graph.selected
        assert row is not None
        if row.resource.kind == TOPIC:
            show_topic(desk, row.resource.name, row.resource.types)
        else:
            desk.open(ShowText(row.resource.name, row.details))


class ShowFrames(Command):
    id, verbs = "tf", ("tf",)
    help = "Show the transforms: parents, ages, rates, and what is wrong"

    def run(self, desk: Desk) -> None:
        desk.open(FrameList(desk))


def show_topic(desk: Desk, name: str, types: Sequence[str]) -> None:
    """Open the dialog of a topic, with its live fields, plots, definition and QoS."""
    desk.open(TopicDialog(desk, name, types))


class FrameList(ListDialog[str]):
    """A list of the transforms, which are received while it is open; it changes each second."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(
            "Transforms",
            lambda line, width, _: [(part, "") for part in textwrap.wrap(line, max(width, 20))],
            lambda line: line.partition(":")[0],
        )
        self._desk = desk

    def on_mount(self) -> None:
        self.show_view(self._desk.view)
        start_worker(self, self._receive, "transforms")

    async def _receive(self) -> None:
        async with self._desk.station.robot.listen_to_frames():
            await asyncio.Event().wait()  # It is cancelled when the dialog closes.

    def show_view(self, view: View) -> None:
        """Show the transforms of a new view."""
        self.show_items(transform_lines(view.snapshot.transforms, view.now))


_GROUP = "topic"  # Of workers for whose answers the console's end does not wait.
_OF_ELEMENTS = ("fields", "is_cut", "open_arrays")  # What `TopicView.with_elements` changes.
_PLOT_ROWS = 6  # Of one plot, with its caption, where there is room.
_PLOT_SHARE = 0.4  # Of the height, that all plots take at most.
_KEYS = "enter fold  p plot  P publish  space freeze  / narrow  t type  y copy  esc close"
_FEW_KEYS = "p plot  space freeze  / narrow  esc close"


class TopicDialog(Dialog):
    """A topic's fields as a list with live values, plots of some, and both ends of the topic.

    The dialog covers the panels only, so that the robot's state and the banner stay in sight. The
    topic is subscribed to while the dialog is open.
    """

    # Where the line of titles, and then the ends, have no room, and where the Graph is in sight.
    VERTICAL_BREAKPOINTS = [(0, "-lowest"), (14, "-low"), (HEAD_FROM, "-high"), (TALL, "-tall")]
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (WIDE, "-wide")]

    BINDINGS = [
        ("escape", "leave", "Leave the search, or close"),
        ("q", "close", "Close"),
        ("enter", "fold", "Open or close a message or an array"),
        ("p", "plot", "Plot the field, or plot it no more"),
        ("P", "publish", "Publish a message to the topic"),
        ("space", "freeze", "Show no newer messages, or show them again"),
        ("slash", "narrow", "Show the fields whose path has a text"),
        ("t", "show_type", "The definition of the type"),
        ("y", "copy", "Copy the ros2 command that shows the topic"),
    ]

    def __init__(self, desk: Desk, name: str, types: Sequence[str]) -> None:
        super().__init__()
        self._desk, self._topic, self._types = desk, name, types
        self._view = TopicView(name)
        self._folded: set[str] = set()  # The groups that are folded, by path.
        self._open_arrays: Mapping[str, int] = {}
        self._plotted: list[str] = []
        self._is_frozen = False
        self._border = "", ""  # The texts on it: topic and type, and the keys.
        self._summary, self._titles = Line(classes="summary"), Line(classes="titles")
        self._rows: Rows[FieldView] = Rows(
            self._draw_field,
            lambda field: field.path,
            id="topic-fields",
            empty="",
            action="screen.fold",
            columns=field_columns,
        )
        self._search = Search(self._rows, self._show_fields)
        self._plot, self._ends = Line(id="topic-plots"), VerticalScroll(id="topic-ends")
        self._box = Vertical(classes="dialog topic")

    def body(self) -> ComposeResult:
        with self._box:
            self._box.border_title = escape(self._topic)
            yield self._summary
            yield self._titles
            yield self._rows
            yield self._search.line
            self._plot.display = False
            yield self._plot
            with self._ends:
                yield Static(id="topic-ends-text")

    def on_mount(self) -> None:
        self.set_class(bool(self._desk.view.replay), "-over-replay")
        self._rows.show_cursor()
        self.set_focus(self._rows)
        self._show(self._view)
        start_worker(self, self._follow_topic, _GROUP)

    async def _follow_topic(self) -> None:
        await self._desk.station.robot.follow_topic(self._topic, self._request, self._receive)

    def on_resize(self) -> None:
        self.call_after_refresh(self._show_again)

    def _request(self) -> TopicRequest:
        top = self._rows.scroll_offset.y
        seen = self._rows.items[top : top + self._rows.size.height]
        return TopicRequest(
            self._open_arrays,
            frozenset(field.path for field in seen),
            curve_columns(self._rows.columns),
            tuple(self._plotted),
            plot_columns(self._plot.size.width) if self._plotted else 0,
        )

    def _receive(self, view: TopicView) -> None:
        # A view that was asked for before an array was opened has not its elements.
        is_older = bool(view.fields) and view.open_arrays != self._open_arrays
        if self._is_frozen:
            self._show(self._with_frozen_message(view))
        elif not is_older:
            self._show(view)

    def _with_frozen_message(self, view: TopicView) -> TopicView:
        """Return a newer view with the fields and curves of the frozen one."""
        kept = {name: getattr(self._view, name) for name in (*_OF_ELEMENTS, "with_elements")}
        return view._replace(plots={**view.plots, **self._view.plots}, **kept)

    def _show_again(self) -> None:
        self._show(self._view)

    def _show(self, view: TopicView) -> None:
        """Show a view, or above the fields why it cannot be drawn; not in a dismissed dialog."""
        if self.is_dismissed:
            return
        had_ends, self._view = self._view.ends, view
        try:
            self._draw_view(view, had_ends)
        except Exception as error:  # A robot's message must not end the console.
            self._summary.show_spans(((not_drawn(error), WARN),))

    def _draw_view(self, view: TopicView, had_ends: TopicInfo | None) -> None:
        self._show_border()
        self._summary.show_spans(summary(view, is_frozen=self._is_frozen))
        if view.ends is not None and view.ends != had_ends:
            self.set_text("#topic-ends-text", content(topic_lines(view.ends)).rstrip())
        self._show_fields()
        self._show_plots()

    def _show_border(self) -> None:
        view, width = self._view, self._box.outer_size.width or self.app.size.width
        kind = view.type if width > len(view.topic + view.type) + 8 else base_name(view.type)
        title = escape(f"{view.topic}   {kind}".rstrip())
        keys = _KEYS if width > len(_KEYS) + 4 else _FEW_KEYS
        if (title, keys) != self._border:  # Setting it draws the whole box.
            self._border = title, keys
            self._box.border_title, self._box.border_subtitle = title, keys

    def _show_fields(self) -> None:
        shown = [field for field in self._view.fields if not self._is_folded(field.path)]
        found = [field for field in shown if self._search.matches(field.path)]
        self._search.show_count(len(found), len(shown))
        self._rows.show(found, f"no field has {self._search.search_text}" if shown else "")
        self._titles.show(Content.styled(field_titles(self._columns), "bold"))

    def _is_folded(self, path: str) -> bool:
        return any(path.startswith((f"{closed}.", f"{closed}[")) for closed in self._folded)

    def _show_plots(self) -> None:
        if self._plot.display != bool(self._plotted):
            self._plot.display = bool(self._plotted)
            self.call_after_refresh(self._show_again)  # It has no size before.
        if self._plotted:
            fields = {field.path: field for field in self._view.fields}
            height = min(
                _PLOT_ROWS * len(self._plotted) + 1, int(self._box.size.height * _PLOT_SHARE)
            )
            if self._plot.styles.height is None or self._plot.styles.height.value != height:
                self._plot.styles.height = height
            size = self._plot.size.width, height
            self._plot.show_spans(*topic_plots(fields, self._view.plots, self._plotted, size))

    @property
    def _columns(self) -> Columns:
        return self._rows.columns or field_columns((), self._rows.size.width)

    def _draw_field(self, field: FieldView, _width: int, columns: Columns) -> list[Text]:
        return [field_line(field, columns, self._folded, self._plotted)]

    def action_leave(self) -> None:
        """Close the search if it is open, else the dialog."""
        if self._search.value or self.focused is self._search:
            self._search.close()
        else:
            self.dismiss()

    def action_publish(self) -> None:
        commands = (command for command in self._desk.registry if isinstance(command, AnyTopic))
        for command in commands:  # There is none in a replay.
            start_worker(self.app, partial(command.open_form, self._desk, self._topic), COMMANDS)

    def action_narrow(self) -> None:
        """Open the search field, which narrows the list to the fields whose path has a text."""
        self._search.open()

    def action_fold(self) -> None:
        """Open or close the message or array under the cursor, or show the next elements."""
        field = self._rows.item
        if field is None or field.kind is FieldKind.VALUE:
            return
        open_arrays = dict(self._open_arrays)
        if field.kind is FieldKind.GROUP:
            self._folded ^= {field.path}
            self._show_fields()
            self._rows.redraw_changed()
            return
        if field.kind is FieldKind.ARRAY and field.path in open_arrays:
            del open_arrays[field.path]
        elif field.kind is FieldKind.ARRAY:
            open_arrays[field.path] = 0
        else:
            array, length = field.path[:-2], int(field.value or 0)
            following = open_arrays.get(array, 0) + SHOWN_ELEMENTS
            open_arrays[array] = following if following < length else 0
        self._show_elements(open_arrays)

    def _show_elements(self, open_arrays: Mapping[str, int]) -> None:
        """Open exactly these arrays (by path, with the first element), and close all others.

        The elements are read on another thread; keys are held until they are shown.
        """
        self._open_arrays, before = open_arrays, self._view

        def show(read: TopicView) -> None:
            if self._view is not before and self._is_frozen:  # A newer view of that message.
                changed = {name: getattr(read, name) for name in _OF_ELEMENTS}
                self._show(self._view._replace(**changed))
            elif self._view is before:  # Otherwise a newer message is shown, with the elements.
                self._show(read)

        if before.with_elements is not None:
            read = partial(in_daemon, before.with_elements, before, open_arrays)
            self.ask(read, show, group=_GROUP)

    def action_plot(self) -> None:
        """Plot the field under the cursor if it is a number, or remove its plot."""
        field = self._rows.item
        if field is None:
            return
        if field.path in self._plotted:
            self._plotted.remove(field.path)
        elif field.kind is FieldKind.VALUE and not isinstance(field.value, str):
            self._plotted.append(field.path)
        else:
            self.notify(f"{field.path} is no number", severity="warning", markup=False)
        self._rows.redraw_changed()
        self._show_plots()

    def action_freeze(self) -> None:
        """Keep the message that is shown, or show new ones again; age and rate go on."""
        self._is_frozen = not self._is_frozen
        self._show(self._view)

    def action_copy(self) -> None:
        """Copy the command that shows the topic in a shell, and say so."""
        command = ros2_command.echo(self._topic, self._view.type)
        self._desk.copy_to_clipboard(command)
        self._desk.show_message(command, title="Copied the command")

    def action_show_type(self) -> None:
        """Read the definition of the type, and show it in a dialog over this one; keys wait."""

        def show(text: str) -> None:
            if not self.is_dismissed:
                self.app.push_screen(ShowText(self._topic, text))

        self.ask(partial(in_daemon, definitions_text, self._types), show, group=_GROUP)
