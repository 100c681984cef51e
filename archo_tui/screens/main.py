"""The one screen: header, banner, eight numbered panels, footer."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.geometry import Size
from textual.markup import escape
from textual.message import Message
from textual.reactive import Reactive
from textual.widget import Widget

from archo_tui.errors import in_one_line
from archo_tui.robot.state import Snapshot
from archo_tui.robot.text import harmless
from archo_tui.screens.base import Base
from archo_tui.terminal.compositor import DirtyCompositor, LayoutOnly
from archo_tui.widgets import bars
from archo_tui.widgets.bars import FooterKey
from archo_tui.widgets.battery_panel import BatteryPanel
from archo_tui.widgets.board import Board
from archo_tui.widgets.button import Button
from archo_tui.widgets.events_panel import EventsPanel
from archo_tui.widgets.field import Field
from archo_tui.widgets.goal_panel import GoalPanel
from archo_tui.widgets.graph_panel import GraphPanel
from archo_tui.widgets.history_panel import HistoryPanel
from archo_tui.widgets.line import Line
from archo_tui.widgets.motion_panel import MotionPanel
from archo_tui.widgets.nodes_panel import NodesPanel
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.parameters_panel import ParametersPanel
from archo_tui.widgets.rows import Rows
from archo_tui.widgets.screen_state import ScreenState
from archo_tui.widgets.search import Search

_WIDE, _TALL = 150, 30  # cells from which there are three columns
_AROUND = 3  # rows of header, banner and footer
_BORDER = 2
_PLOTS = 17  # rows of the history: fewer are too small for its plots
_EVENTS = 10  # rows of the events, at least
_AWAITED = 0.3  # s that the first picture waits for the robot's nodes, or all is drawn twice
_LATEST = 0.5  # s after which the screen is drawn, laid out for its size or not


def _class_of(cells: int, breakpoints: Sequence[tuple[int, str]]) -> str:
    """The one that Textual will give it, known before all is laid out and styled again for it."""
    return max((least, name) for least, name in breakpoints if cells >= least)[1]


class MainScreen(Base[None]):
    """Lays the panels out for the terminal's size and hands them every new view."""

    HORIZONTAL_BREAKPOINTS = [(0, "-tiny"), (80, "-narrow"), (110, "-normal"), (_WIDE, "-wide")]
    VERTICAL_BREAKPOINTS = [(0, "-short"), (_TALL, "-tall")]

    class Broken(Message):
        """A panel could not be drawn."""

        def __init__(self, said: str) -> None:
            super().__init__()
            self.said = said

    # Textual's own would draw the whole screen anew; what gains or loses the focus draws itself
    focused: Reactive[Widget | None] = Reactive(None, repaint=False)

    _before: Widget | None = None  # had the focus before a panel was asked for
    _focused_last: Widget | None = None
    _fitted: tuple[int | None, int | None] = None, None  # rows of the nodes, and of what is above
    _asked = False  # a panel was; until then a small terminal shows the first ones

    def __init__(self, snapshot: Snapshot, size: Size, time_line: Panel | None = None) -> None:
        """`snapshot` knows the robot's file; `size` is the terminal's.

        Over a `time_line` it only shows: what was recorded.
        """
        of_size = _class_of(size.width, self.HORIZONTAL_BREAKPOINTS)
        super().__init__(classes=f"{of_size} {_class_of(size.height, self.VERTICAL_BREAKPOINTS)}")
        self._compositor = DirtyCompositor()
        robot = snapshot.file
        self._body = LayoutOnly(id="body")
        self._grid = LayoutOnly(id="panels", classes="-gauges" if robot.gauges else "")
        self.goal, self.parameters = GoalPanel(snapshot), ParametersPanel()
        self.nodes, self.events, self.history = NodesPanel(), EventsPanel(), HistoryPanel(robot)
        self.graph = GraphPanel()
        above = BatteryPanel(robot), MotionPanel(robot), self.goal
        panels = (*above, self.parameters, self.nodes, self.events, self.history, self.graph)
        self._panels: dict[int, Panel] = {panel.number: panel for panel in panels}
        self._time_line = time_line
        if time_line is not None:
            self._panels[time_line.number] = time_line
            for panel in above:
                panel.can_focus = True
            self.goal.make_read_only()
            self.add_class("-replay")
        self._header, self._clock = Line(id="header"), Line(id="clock")
        self._banner, self._footer = Line(id="banner"), Line(id="footer")
        self._below: object = None  # what the footer shows
        self.everywhere = Content("")  # of the footer what works in dialogs, too
        self._is_laid_out = self._is_filled = False
        self._view: ScreenState | None = None  # the last one
        self._commands: list[FooterKey] = []  # those of its footer
        self._broken: dict[int, str] = {}  # what was said of panels that could not be drawn

    def compose(self) -> ComposeResult:
        with Horizontal(id="head"):
            yield self._header
            yield self._clock
        yield self._banner
        with self._body:
            with self._grid:
                with LayoutOnly(id="left"):
                    yield from (self._panels[number] for number in (1, 2, 5, 8))
                with LayoutOnly(id="right"):
                    yield from (self._panels[number] for number in (3, 4))
                yield from (self.history, self.events)
        if self._time_line is not None:
            yield self._time_line
        yield self._footer

    def on_mount(self) -> None:
        self.app.theme_changed_signal.subscribe(self, lambda _: self._mark_focused())
        self.set_timer(_AWAITED, self._fill)
        self.set_timer(_LATEST, self._draw_from_now_on)  # behind a dialog no size may come
        self._focused_last = self._time_line or self.parameters.focus_target
        self.set_focus(self._focused_last, scroll_visible=False)  # nobody asked: without a cursor

    def watch_focused(self) -> None:
        self._mark_focused()
        focused = self.focused
        if focused is not None and focused is not self._focused_last:
            self._focused_last = focused  # the terminal may lose the focus and give it back
            if isinstance(focused, Rows):  # by tab or a click
                focused.show_cursor()
        if self._view is not None and self._is_filled:
            self._show_footer(self._view, self._commands)

    def _mark_focused(self) -> None:
        """By hand: a style for `:focus-within` has Textual look at all that the panels contain."""
        focused = self.focused_panel
        for panel in self._panels.values():
            panel.mark_focused(panel.number == focused)

    @property
    def focus_chain(self) -> list[Widget]:
        """In the order of the panels' numbers, at every size; buttons and searches come last."""
        for panel in self._panels.values():  # what a class shows or hides, Textual notices later
            panel._nodes.updated()
        return sorted(super().focus_chain, key=_place_in_chain)

    @property
    def focused_panel(self) -> int:
        """The number of the panel that has the focus, 0 for none."""
        return 0 if self.focused is None else _panel_number(self.focused)

    @property
    def search(self) -> Search | None:
        """What narrows the rows of the panel with the focus; None: nothing does."""
        for panel in (self.parameters, self.events):
            if panel.number == self.focused_panel and panel.search.search_text:
                return panel.search
        return None

    def shows_stop_at(self, x: int, y: int) -> bool:
        """True where the button of STOP is, whatever stands in front of this screen."""
        if not self.is_mounted:
            return False
        widget, _ = self.get_widget_and_offset_at(x, y)
        return widget is not None and widget.id == "stop"

    @property
    def is_full(self) -> bool:
        """True while one panel has the full screen."""
        return self.has_class("-full")

    def toggle_full(self, panel: Panel) -> None:
        """A panel on the full screen, or among the others."""
        if self.has_class(f"-full-{panel.number}"):
            self.leave_full()
            return
        self._before = self.focused
        self._show_all()
        self.add_class("-full", f"-full-{panel.number}")
        self._fit()
        panel.take_focus()

    def leave_full(self) -> None:
        """All panels again; where the one that had the screen has no room, the focus goes back."""
        self._show_all()
        focused = self._panels.get(self.focused_panel)
        if focused is not None and not self._has_room(focused):
            self.focus_back()

    def _show_all(self) -> None:
        self.remove_class("-full", *(f"-full-{number}" for number in self._panels))
        self._fit()

    def _has_room(self, panel: Panel) -> bool:
        """True when it stands among the others in a terminal of this size."""
        return panel not in (self.history, self.graph) or self._is_wide

    @property
    def _is_wide(self) -> bool:
        """True where there are three columns."""
        return self.size.width >= _WIDE and self.size.height >= _TALL

    def _fit(self) -> None:
        """In three columns, lists get the height of what they list, as far as there is room."""
        nodes, upper = None, None
        if self._is_wide and not self.is_full:
            most = self.size.height - _AROUND
            nodes = min(max(self.nodes.lines, 5), 12) + _BORDER
            goal = self.goal.styles.height
            wanted = int(goal.value if goal else 0) + self.parameters.lines + _BORDER
            upper = min(max(wanted, _PLOTS), most - max(_EVENTS, most // 3))
        if (nodes, upper) != self._fitted:
            self._fitted = nodes, upper
            self.nodes.styles.height = nodes
            if upper is None:
                self._grid.styles.clear_rule("grid_rows")
            else:
                self._grid.styles.grid_rows = f"{upper} 1fr"

    def focus_panel(self, number: int) -> None:
        """Focus a panel by its number; one that the full screen hides brings the others back."""
        if not self.has_class(f"-full-{number}"):
            self._show_all()
            if not self._has_room(self._panels[number]):
                self.toggle_full(self._panels[number])
                return
        if not isinstance(self.focused, Board):  # which escape leaves for the field
            self._before = self.focused
        self._asked = True
        self._panels[number].take_focus()
        self.call_after_refresh(self._show_focused)

    def on_screen_resume(self, event: events.ScreenResume) -> None:
        if not self._is_laid_out:
            event.refresh_styles = False  # all of them were just set

    def _screen_resized(self, size: Size) -> None:
        if (
            self._is_laid_out or size != self.outer_size
        ):  # else it has just been, and was not drawn yet
            super()._screen_resized(size)

    def on_resize(self) -> None:
        self._fit()
        self.call_after_refresh(self._laid_out)

    def _laid_out(self) -> None:
        self._draw_from_now_on()
        if self.focused is None and self.app.app_focus:  # it was where there is no room any more
            self.focus_panel(4)
        self._show_focused()

    def _draw_from_now_on(self) -> None:
        if not self._is_laid_out:
            self._is_laid_out = True
            self.refresh()

    def _compositor_refresh(self) -> None:
        """Draw, but not before the panels are filled and laid out for the terminal's size."""
        if self._is_laid_out and self._is_filled:
            super()._compositor_refresh()

    def _show_focused(self) -> None:
        """Where not all panels have room, the one with the focus is seen whole."""
        panel = self._panels.get(self.focused_panel)
        if panel is not None and self._asked and self._body.max_scroll_y:
            panel.scroll_visible(animate=False)

    def focus_back(self) -> None:
        """Out of a field: focus what had it before, or the parameters."""
        before = self._before
        panel = None if before is None else self._panels.get(_panel_number(before))
        if isinstance(self.focused, Search):
            self.focused.close()
        elif panel is None or before is self.focused or not self._has_room(panel):
            self.focus_panel(4)
        elif isinstance(before, Search):  # out of a field is not into another one
            panel.take_focus()
        else:
            self.set_focus(before)

    def _fill(self) -> None:
        """Show what there is, with a robot or without."""
        if not self._is_filled:
            self._is_filled = True
            if self._view is not None:  # what has no room is filled by the next view
                seen = [panel for panel in self._panels.values() if self._has_room(panel)]
                self._show(self._view, self._commands, seen)
            self.refresh()

    def show(self, view: ScreenState, commands: list[FooterKey]) -> None:
        """Show a new view everywhere; the first one with nodes is the first that is drawn."""
        self._view, self._commands = view, commands
        if not self._is_filled:
            if view.snapshot.nodes:
                self._fill()
            return
        self._show(view, commands, self._panels.values())

    def _show(self, view: ScreenState, commands: list[FooterKey], panels: Iterable[Panel]) -> None:
        width = self.size.width
        self._header.show(bars.header(view, width - 9))
        self._clock.show(bars.clock(view))
        self._banner.show(bars.banner(view, width))
        self._show_footer(view, commands)
        for panel in panels:
            self._show_panel(panel, view)
        self._fit()

    def _show_footer(self, view: ScreenState, commands: list[FooterKey]) -> None:
        """Show the keys that work now: of a field that has the focus, its own."""
        focused = self.focused
        field_keys = focused.keys if isinstance(focused, Field) else ()
        below = commands, self.size.width, view.key("palette"), field_keys
        if below != self._below:  # some ten texts: not at each view
            self._below = below
            self._footer.show(bars.footer(*below))
            self.everywhere = bars.footer_keys(key for key in commands if key.everywhere)

    def on_panel_resized(self, message: Panel.Resized) -> None:
        if self._view is not None and self._is_filled:
            self._show_panel(message.panel, self._view)

    def _show_panel(self, panel: Panel, view: ScreenState) -> None:
        try:
            panel.show(view)
            if self._broken.pop(panel.number, ""):
                panel.remove_class("-broken")
                panel.show_title("")
        except Exception as error:  # the others, STOP and the clock go on
            self._cannot_draw(panel, error)

    def _cannot_draw(self, panel: Panel, error: Exception) -> None:
        said = harmless(f"cannot be drawn: {in_one_line(error)}")
        panel.show_title(escape(f"   ✗ {said}"))
        panel.add_class("-broken")  # what stood there is not so any more; its buttons stay
        if self._broken.get(panel.number) != said:
            self._broken[panel.number] = said
            self.post_message(self.Broken(f"panel {panel.number} {said}"))


def _place_in_chain(widget: Widget) -> tuple[int, bool]:
    return _panel_number(widget), isinstance(widget, (Button, Search))  # the rest by their places


def _panel_number(widget: Widget) -> int:
    for node in widget.ancestors_with_self:
        if isinstance(node, Panel):
            return node.number
    return 0
