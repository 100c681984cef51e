"""The table of the numbered panels."""

from __future__ import annotations

from archo_tui.widgets.battery_panel import BatteryPanel
from archo_tui.widgets.events_panel import EventsPanel
from archo_tui.widgets.goal_panel import GoalPanel
from archo_tui.widgets.graph_panel import GraphPanel
from archo_tui.widgets.history_panel import HistoryPanel
from archo_tui.widgets.motion_panel import MotionPanel
from archo_tui.widgets.nodes_panel import NodesPanel
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.parameters_panel import ParametersPanel

# In the order of their numbers, from 1. Keys, footer, `?` and the screen follow from it.
PANELS: tuple[type[Panel], ...] = (
    *(BatteryPanel, MotionPanel, GoalPanel, ParametersPanel),
    *(NodesPanel, EventsPanel, HistoryPanel, GraphPanel),
)
for number, kind in enumerate(PANELS, 1):
    kind.number = number
