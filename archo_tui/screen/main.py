"""The main screen: header, banner, numbered panels and footer."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from textual.app import ComposeResult
from textual.containers import Container, Horizontal
from textual.content import Content
from textual.geometry import Region, Size
from textual.markup import escape
from textual.reactive import Reactive
from textual.widget import Widget

from archo_tui.base.errors import in_one_line
from archo_tui.base.safe_text import harmless
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.base import Base
from archo_tui.screen.widgets import bars
from archo_tui.screen.widgets.bars import FooterKey, Notice, NoticeLine
from archo_tui.screen.widgets.battery_panel import BatteryPanel
from archo_tui.screen.widgets.events_panel import EventsPanel
from archo_tui.screen.widgets.field import Button, Field, Search
from archo_tui.screen.widgets.goal_panel import GoalPanel
from archo_tui.screen.widgets.graph_panel import GraphPanel
from archo_tui.screen.widgets.history_panel import HistoryPanel
from archo_tui.screen.widgets.line import Line
from archo_tui.screen.widgets.motion_panel import MotionPanel
from archo_tui.screen.widgets.nodes_panel import NodesPanel
from archo_tui.screen.widgets.panel import Panel, ScreenState
from archo_tui.screen.widgets.parameters_panel import ParametersPanel
from archo_tui.screen.widgets.rows import Rows

P = TypeVar("P", bound=Panel)

# In the order of their numbers, from 1. Keys, footer, `?` and the screen follow from it.
# Eight have room: the digit behind the last is that of a replay's time line.
PANELS: tuple[type[Panel], ...] = (
    *(BatteryPanel, MotionPanel, GoalPanel, ParametersPanel),
    *(NodesPanel, EventsPanel, HistoryPanel, GraphPanel),
)
for number, kind in enumerate(PANELS, 1):
    kind.number = number

WIDE, TALL = 150, 30  # Cells from which on there are three columns.
_FIELD_WIDTH, _FIELD_HEIGHT = 80, 20  # Cells from which on the goal's field is in sight.
_NARROW = 80  # Cells below which panels lie one below the other.
_NORMAL, _HIGH = 110, 44  # Cells from which on the history is below.
_CLOCK = 9  # Cells of the time of day.
_AROUND = 3  # Rows of header, banner and footer.
_TIME_LINE = 2  # Rows of the time line of a replay.
_BORDER = 2  # Rows of a panel's border.
_MIN_HISTORY = 17  # Rows of the history; its plots would be too small in fewer.
_MIN_EVENTS = 8  # Rows of the events where there are 30 rows.
_MOST_EVENTS = 11  # From 44 rows on, where the history has the others.
_FEW_EVENTS, _FEW_PARAMETERS = 5, 5  # Rows with a border on a small one, for three and for two.
# Seconds that the first drawing waits for the robot's nodes, so that it is not done twice.
_NODES_TIMEOUT = 0.3
# Seconds until the screen is drawn even if no layout for its size was reported.
_LAYOUT_TIMEOUT = 0.5


def _class_of(cells: int, breakpoints: Sequence[tuple[int, str]]) -> str:
    """Return the CSS class that Textual sets for a width or height, by its breakpoints.

    If it is set from the start, Textual need not lay out everything a second time.
    """
    return max((minimum, name) for minimum, name in breakpoints if cells >= minimum)[1]


class MainScreen(Base):
    """The panels, laid out for the terminal's size, with header, banner and footer.

    Nothing is drawn until a view with nodes has come, or for 0.3 s. A panel that cannot be drawn
    shows why in its title, and the others go on.
    """

    HORIZONTAL_BREAKPOINTS = [
        *[(0, "-tiny"), (_NARROW, "-narrow"), (_NORMAL, "-normal"), (WIDE, "-wide")]
    ]
    VERTICAL_BREAKPOINTS = [(0, "-short"), (TALL, "-tall"), (_HIGH, "-high")]

    # Called when a panel cannot be drawn, with the reason if that is new. Set by the owner.
    on_broken: Callable[[str], object]
    # Textual's own reactive would redraw the whole screen. The widgets that gain and lose the
    # focus redraw themselves.
    focused: Reactive[Widget | None] = Reactive(None, repaint=False)

    _focused_before: Widget | None = None  # Before a panel was focused by its number.
    _focused_last: Widget | None = None
    _heights: tuple[int | None, str] = None, ""  # Rows of the nodes; of the grid.
    _is_panel_chosen = False  # Until one is, a small terminal shows the first panels.

    def __init__(
        self,
        snapshot: Snapshot,
        size: Size,
        time_line: Panel | None = None,
        *,
        # True: the goal's field has the focus at first, where it is in sight.
        starts_in_field: bool = False,
    ) -> None:
        """Create the screen; with a `time_line`, that of a replay, it is read-only."""
        width_class = _class_of(size.width, self.HORIZONTAL_BREAKPOINTS)
        height_class = _class_of(size.height, self.VERTICAL_BREAKPOINTS)
        super().__init__(classes=f"{width_class} {height_class}")
        robot = snapshot.file
        self._body = Container(id="body")
        self._grid = Container(id="panels", classes="-gauges" if robot.gauges else "")
        self._panels = [kind(snapshot) for kind in PANELS]
        self.goal, self.parameters = self._panel(GoalPanel), self._panel(ParametersPanel)
        self._motion = self._panel(MotionPanel)
        self.nodes, self.events = self._panel(NodesPanel), self._panel(EventsPanel)
        self.history, self.graph = self._panel(HistoryPanel), self._panel(GraphPanel)
        self.goal.on_typed = self._on_field_changed
        self._time_line, self.starts_in_field = time_line, starts_in_field
        if time_line is not None:
            self._panels.append(time_line)
            self.goal.can_focus = True  # Its form is hidden.
            self.add_class("-replay")
        self._header, self._clock = Line(id="header"), Line(id="clock")
        self._banner, self._footer = Line(id="banner"), Line(id="footer")
        self._footer_content: object = None  # From what the footer was drawn.
        self.everywhere_keys = Content("")  # The footer's, of the keys that work in dialogs, too.
        self.head: list[Content] = []  # The lines at the top, as shown last.
        self.notices: Sequence[Notice] = ()  # Over the last of these lines, or below them.
        # Of open dialogs: called whenever lines or notices are shown.
        self.on_head: list[Callable[[], None]] = []
        self._notice_line = NoticeLine()
        self._is_laid_out = self._is_filled = False
        self._view: ScreenState | None = None  # The last one.
        self._commands: list[FooterKey] = []  # The keys of its footer.
        self._broken: dict[Panel, str] = {}  # Why some cannot be drawn.

    def _panel(self, kind: type[P]) -> P:
        return next(panel for panel in self._panels if isinstance(panel, kind))

    def compose(self) -> ComposeResult:
        with Horizontal(id="head"):
            yield self._header
            yield self._clock
        yield self._banner
        with self._body:
            with self._grid:
                for column in ("left", "right"):
                    with Container(id=column):
                        yield from (p for p in self._panels if p.place == column)
                for place in ("beside", "below"):
                    yield from (p for p in self._panels if p.place == place)
        if self._time_line is not None:
            yield self._time_line
        yield self._footer
        yield self._notice_line

    def on_mount(self) -> None:
        self.set_timer(_NODES_TIMEOUT, self._fill)
        # Behind a dialog, the screen may get no Resize event.
        self.set_timer(_LAYOUT_TIMEOUT, self._draw_from_now_on)
        self._focused_last = self._time_line or self._first_field or self.parameters.focus_target
        # No person has moved the focus there, so a list shows no cursor yet.
        self.set_focus(self._focused_last, scroll_visible=False)

    @property
    def _first_field(self) -> Widget | None:
        """The goal's field, if that is in sight and takes no letters, for the focus at first."""
        size = self.app.size
        if not self.starts_in_field or size.width < _FIELD_WIDTH or size.height < _FIELD_HEIGHT:
            return None
        return self.goal.first_field

    def watch_focused(self) -> None:
        focused = self.focused
        if focused is not None and focused is not self._focused_last:
            # When the terminal gets the focus back, the same widget is focused again.
            self._focused_last = focused
            if isinstance(focused, Rows):  # A tab or a click has moved the focus there.
                focused.show_cursor()
        self._on_field_changed()

    @property
    def focus_chain(self) -> list[Widget]:
        """The widgets that tab visits, by panel at every size, buttons and searches last."""
        return sorted(super().focus_chain, key=_tab_order)

    @property
    def nearest_focus(self) -> Widget | None:
        """The widget with the focus if it is shown, else the list of parameters if that is."""
        found, parameters = super().nearest_focus, self.parameters.focus_target
        is_other = found is not self.focused and parameters in self.focus_chain
        return parameters if is_other else found

    @property
    def panel_with_focus(self) -> Panel | None:
        """The panel with the focus; None if no panel has it."""
        return None if self.focused is None else _panel_of(self.focused)

    @property
    def search(self) -> Search | None:
        """The search of the panel with the focus if a text narrows its list; else None."""
        for panel in (self.parameters, self.events):
            if panel is self.panel_with_focus and panel.search.search_text:
                return panel.search
        return None

    def shows_stop_at(self, x: int, y: int) -> bool:
        """Return True if the STOP button is at a cell of this screen, a dialog over it or not."""
        if not self.is_mounted:
            return False
        # A notice may be over it.
        return any(widget.id == "stop" for widget, _ in self.get_widgets_at(x, y))

    @property
    def is_full(self) -> bool:
        """True while one panel fills the screen."""
        return self.has_class("-full")

    def toggle_full(self, panel: Panel) -> None:
        """Let a panel fill the screen and focus it, or show all panels again if it does already."""
        if panel.has_class("-fills"):
            self.leave_full()
            return
        self._focused_before = self.focused
        self._show_all()
        self.add_class("-full")
        for node in (panel, panel.parent):
            if isinstance(node, Widget):
                node.add_class("-fills")
        self._fit()
        panel.take_focus()

    def leave_full(self) -> None:
        """Show all panels again; the focus goes back if its panel has no room among them."""
        self._show_all()
        focused = self.panel_with_focus
        if focused is not None and not self._has_room(focused):
            self.focus_back()

    def _show_all(self) -> None:
        self.remove_class("-full")
        self.query(".-fills").remove_class("-fills")
        self._fit()

    def _has_room(self, panel: Panel) -> bool:
        """Return True if a panel is shown among the others at this size."""
        return not panel.needs_room or self._is_wide or self._is_large

    @property
    def _is_wide(self) -> bool:
        return self.size.width >= WIDE and self.size.height >= TALL

    @property
    def _is_large(self) -> bool:
        return self.size.width >= _NORMAL and self.size.height >= _HIGH

    @property
    def _height(self) -> int:
        """The number of rows that the panels share."""
        return self.size.height - _AROUND - (_TIME_LINE if self._time_line is not None else 0)

    def _fit(self) -> None:
        """Set the heights of the panels by the length of their lists; Events have what is left."""
        nodes, rows = None, ""  # On a tiny screen, or full of one panel, the style sheet does it.
        if self.size.width >= _NARROW and not self.is_full:
            listed = min(max(self.nodes.lines, 5), 12) + _BORDER
            nodes = listed if self._is_wide or self._is_large else None
            rows = self._rows_of_grid(listed)
        if (nodes, rows) != self._heights:
            self._heights = nodes, rows
            self.nodes.styles.height = nodes
            if rows:
                self._grid.styles.grid_rows = rows
            else:
                self._grid.styles.clear_rule("grid_rows")

    def _rows_of_grid(self, nodes: int) -> str:
        """Return the heights of the rows of panels, as Textual writes them."""
        least = self._grid.styles.min_height
        height = max(self._height, int(least.value) if least else 0)
        goal = int(self.goal.styles.height.value) if self.goal.styles.height else 0
        if self._is_large:
            upper = goal + self._parameter_rows(height - _MIN_HISTORY - _MIN_EVENTS - goal)
            events = max(min(height // 4, _MOST_EVENTS, height - upper - _MIN_HISTORY), _MIN_EVENTS)
            return f"{upper} 1fr {events}"
        if self._is_wide:
            most = height - max(_MIN_EVENTS, height // 3)
            return f"{max(goal + self._parameter_rows(most - goal), _MIN_HISTORY)} 1fr"
        few_events = _MIN_EVENTS if self.size.height >= TALL else _FEW_EVENTS
        if self.size.width >= _NORMAL:
            above = (p for p in self._panels if p.place == "left" and p.number < self.nodes.number)
            left = sum(panel.outer_size.height for panel in above) + nodes
            most = height - few_events
            return f"{min(max(left, goal + self._parameter_rows(most - goal)), most)} 1fr"
        top = 7 if self._grid.has_class("-gauges") else 5
        is_searched = self.events.search.line.display  # The field has one of the rows.
        few = _FEW_PARAMETERS - 2 if is_searched else _FEW_PARAMETERS
        room = max(height - top - goal - few_events, few)
        return f"{top} {goal + self._parameter_rows(room)} 1fr"

    def _parameter_rows(self, most: int) -> int:
        """Return the rows of Parameters, with descriptions if all of them have room."""
        wanted = (max(lines + _BORDER, _FEW_PARAMETERS) for lines in self.parameters.lines)
        return next((rows for rows in wanted if rows <= most), most)

    def focus_panel(self, number: int) -> None:
        """Focus a panel by its number, and scroll to it; without room, it fills the screen.

        The widget that had the focus is remembered for `focus_back`.
        """
        panel = next(panel for panel in self._panels if panel.number == number)
        if not panel.has_class("-fills"):
            self._show_all()
            if not self._has_room(panel):
                self.toggle_full(panel)
                return
        self._focused_before = self.focused
        self._is_panel_chosen = True
        panel.take_focus()
        self.call_after_refresh(self._show_focused)

    def on_resize(self) -> None:
        """Set the heights of the panels, and draw and scroll once they are laid out."""
        self._fit()
        self.call_after_refresh(self._after_layout)

    def _after_layout(self) -> None:
        self._fit()  # Some heights are those of the panels beside.
        self._draw_from_now_on()
        # The widget that had the focus has no room any more.
        if self.app.app_focus and self.focused not in self.focus_chain:
            self.focus_panel(self.parameters.number)
        self._show_focused()

    def _draw_from_now_on(self) -> None:
        if not self._is_laid_out:
            self._is_laid_out = True
            self.refresh()

    def _compositor_refresh(self) -> None:
        """Draw what has changed, once the panels are filled and laid out; before, do nothing."""
        if self._is_laid_out and self._is_filled:
            super()._compositor_refresh()

    def _show_focused(self) -> None:
        """Scroll to the panel with the focus, once a panel was chosen by its number."""
        panel = self.panel_with_focus
        if panel is not None and self._is_panel_chosen and self._body.max_scroll_y:
            panel.scroll_visible(animate=False)

    def focus_back(self) -> None:
        """Focus the widget that had the focus before a panel was chosen, or else the parameters.

        If a search has the focus, it is only closed and cleared.
        """
        before = self._focused_before
        panel = None if before is None else _panel_of(before)
        if isinstance(self.focused, Search):
            self.focused.close()
        elif panel is None or before is self.focused or not self._has_room(panel):
            self.focus_panel(self.parameters.number)
        elif isinstance(before, Search):  # That is a field, too: its panel gets the focus.
            panel.take_focus()
        else:
            self.set_focus(before)

    def _fill(self) -> None:
        """Show the last view in the visible panels, and let the screen be drawn; once only."""
        if not self._is_filled:
            self._is_filled = True
            if self._view is not None:  # The next view fills the hidden panels.
                visible = [panel for panel in self._panels if self._has_room(panel)]
                self._show(self._view, self._commands, visible)
            self.refresh()

    def show(self, view: ScreenState, commands: list[FooterKey]) -> None:
        """Show a new view in header, banner, panels and footer."""
        self._commands = commands
        self._view = view = self._with_typed(view)
        if not self._is_filled:
            if view.snapshot.nodes:
                self._fill()
            return
        self._show(view, commands, self._panels)

    def _show(self, view: ScreenState, commands: list[FooterKey], panels: Iterable[Panel]) -> None:
        width = self.size.width
        header, clock = bars.header(view, width - _CLOCK), bars.clock(view)
        self._header.show(header)
        self._clock.show(clock)
        gap = " " * max(width - header.cell_length - clock.cell_length, 0)
        self._show_hints(view, commands, Content.assemble(header, gap, clock))
        for panel in panels:
            self._show_panel(panel, view)
        self._fit()

    def show_notices(self, notices: Sequence[Notice]) -> None:
        """Show notices here, but not over the STOP button, and in the dialogs over this screen."""
        self.notices = notices
        line = self._notice_line
        line.show(notices, self.size.width)
        if notices:
            row = max(len(self.head) - 1, 0) + self.is_banner_needed
            # At the end of the screen its button may be gone already.
            regions = (button.region for button in self.query("#stop"))
            stop = next(regions, Region()).intersection(self._body.region)
            if stop and row < stop.bottom and stop.y < row + line.rows:
                row = stop.bottom
            line.styles.offset = 0, row
        for show in self.on_head:
            show()

    @property
    def is_banner_needed(self) -> bool:
        """True if the last line of the head tells of an alarm or a request."""
        return self._view is not None and bars.is_banner_needed(self._view)

    def _show_hints(self, view: ScreenState, commands: list[FooterKey], header: Content) -> None:
        """Show banner, notices and footer, and keep the lines at the top for dialogs."""
        banner = bars.banner(view, self.size.width)
        self._banner.show(banner)
        self.head = [header, banner]
        self.show_notices(self.notices)
        self._show_footer(view, commands)

    def _with_typed(self, view: ScreenState) -> ScreenState:
        """Return a view with the commands whose keys the focused field takes as text.

        So is `go` where it leads to.
        """
        focused, typed = self.focused, set[str]()
        if isinstance(focused, Field):
            typed = {name for name, key in view.keys.items() if focused.is_typed(key)}
            typed |= {"go"} if focused is self.goal.focused_field else set()
        return view if typed == view.typed else replace(view, typed=frozenset(typed))

    def _on_field_changed(self) -> None:
        """Update what is said of keys: the focus is in another place, or a field has other text."""
        if self._view is not None and self._is_filled:
            self._view = self._with_typed(self._view)
            self._show_hints(self._view, self._commands, self.head[0])
            for panel in self.goal, self._motion:
                self._show_panel(panel, self._view)

    def _show_footer(self, view: ScreenState, commands: list[FooterKey]) -> None:
        """Show the focused field's keys, and those of the commands that are no text in it."""
        field_keys = self.focused.keys if isinstance(self.focused, Field) else ()
        if field_keys:  # Of the others, those that are no text now.
            commands = [c for c in commands if c.everywhere or c.command not in view.typed]
        content = commands, self.size.width, view.key("palette"), field_keys
        if content != self._footer_content:  # Drawing it at each view would take too long.
            self._footer_content = content
            self._footer.show(bars.footer(*content))
            self.everywhere_keys = bars.footer_keys(key for key in commands if key.everywhere)

    def forget_refusal(self) -> None:
        """Remove the refusal in the goal's form, since a key was pressed."""
        self.goal.show_hint()

    def on_panel_outdated(self, message: Panel.Outdated) -> None:
        """Show the last view again in the panel that asks for it."""
        if self._view is not None and self._is_filled:
            self._show_panel(message.panel, self._view)

    def _show_panel(self, panel: Panel, view: ScreenState) -> None:
        try:
            panel.show(view)
            if self._broken.pop(panel, ""):
                panel.remove_class("-broken")
                panel.show_title("")
        except Exception as error:  # The other panels, STOP and the clock must go on.
            self._show_error(panel, error)

    def _show_error(self, panel: Panel, error: Exception) -> None:
        """Show in a panel's title why the panel cannot be drawn."""
        reason = harmless(f"cannot be drawn: {in_one_line(error)}")
        panel.show_title(escape(f"   ✗ {reason}"))
        panel.add_class("-broken")  # It hides the old content, but not the buttons.
        if self._broken.get(panel) != reason:
            self._broken[panel] = reason
            self.on_broken(f"panel {panel.number} {reason}")


def _tab_order(widget: Widget) -> tuple[int, bool]:
    panel = _panel_of(widget)
    return panel.number if panel is not None else 0, isinstance(widget, (Button, Search))


def _panel_of(widget: Widget) -> Panel | None:
    """Return the panel that contains a widget; None if none does."""
    return next((node for node in widget.ancestors_with_self if isinstance(node, Panel)), None)
