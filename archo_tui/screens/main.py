"""The one screen: header, banner, six numbered panels, footer."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import Container, Horizontal
from textual.screen import Screen
from textual.widget import Widget

from archo_tui.station import View
from archo_tui.widgets import bars
from archo_tui.widgets.battery_panel import BatteryPanel
from archo_tui.widgets.events_panel import EventsPanel
from archo_tui.widgets.goal_panel import GoalPanel
from archo_tui.widgets.line import Line
from archo_tui.widgets.motor_panel import MotorPanel
from archo_tui.widgets.nodes_panel import NodesPanel
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.parameters_panel import ParametersPanel
from archo_tui.widgets.search import Search


class MainScreen(Screen[None]):
    """Lays the panels out for the terminal's size and hands them every new view."""

    HORIZONTAL_BREAKPOINTS = [(0, "-tiny"), (80, "-narrow"), (110, "-normal"), (150, "-wide")]
    VERTICAL_BREAKPOINTS = [(0, "-short"), (30, "-tall")]

    _before: Widget | None = None  # had the focus before a panel was asked for

    def compose(self) -> ComposeResult:
        with Horizontal(id="head"):
            yield Line(id="header")
            yield Line(id="clock")
        yield Line(id="banner")
        with Container(id="body"):
            with Container(id="top"):
                with Container(id="left"):
                    yield BatteryPanel()
                    yield MotorPanel()
                    yield NodesPanel()
                with Container(id="right"):
                    yield GoalPanel()
                    yield ParametersPanel()
            yield EventsPanel()
        yield Line(id="footer")

    def on_mount(self) -> None:
        self.focus_panel(4)

    @property
    def focus_chain(self) -> list[Widget]:
        """In the order of the panels' numbers, at every size."""
        return sorted(super().focus_chain, key=_panel_number)

    @property
    def events(self) -> EventsPanel:
        """Panel 6."""
        return self.query_one(EventsPanel)

    @property
    def parameters(self) -> ParametersPanel:
        """Panel 4."""
        return self.query_one(ParametersPanel)

    @property
    def nodes(self) -> NodesPanel:
        """Panel 5."""
        return self.query_one(NodesPanel)

    @property
    def goal(self) -> GoalPanel:
        """Panel 3."""
        return self.query_one(GoalPanel)

    @property
    def focused_panel(self) -> int:
        """The number of the panel that has the focus, 0 for none."""
        return 0 if self.focused is None else _panel_number(self.focused)

    def toggle_events(self) -> None:
        """The events on the full screen, or among the other panels."""
        self.toggle_class("-full")
        self.events.take_focus()

    def focus_panel(self, number: int) -> None:
        """Focus a panel by its number; one that the full screen hides brings the others back."""
        if number != self.events.number:
            self.remove_class("-full")
        self._before = self.focused
        self.query_one(f"#panel-{number}", Panel).take_focus()
        self.call_after_refresh(self._show_focused)

    def on_resize(self) -> None:
        self.call_after_refresh(self._show_focused)

    def _show_focused(self) -> None:
        """Where not all panels have room, the one with the focus is seen whole."""
        for panel in self.query(Panel):
            if panel.number == self.focused_panel:
                panel.scroll_visible(animate=False)

    def focus_back(self) -> None:
        """Out of a field: focus what had it before, or the parameters."""
        if isinstance(self.focused, Search):
            self.focused.close()
        elif self._before is None or self._before is self.focused:
            self.focus_panel(4)
        else:
            self.set_focus(self._before)

    def show(self, view: View, commands: list[tuple[str, str, str, bool]]) -> None:
        """Show a new view everywhere."""
        width = self.size.width
        self.query_one("#header", Line).show(bars.header(view, width - 9))
        self.query_one("#clock", Line).show(bars.clock(view))
        self.query_one("#banner", Line).show(bars.banner(view, width))
        self.query_one("#footer", Line).show(bars.footer(commands, width, view.key("palette")))
        for panel in self.query(Panel):
            panel.show(view)


def _panel_number(widget: Widget) -> int:
    for node in widget.ancestors_with_self:
        if isinstance(node, Panel):
            return node.number
    return 0
