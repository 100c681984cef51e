"""Panel 1: how full, how healthy."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.content import Content

from archo_tui.widgets import trend, words
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.view import View


class BatteryPanel(Panel, can_focus=True):
    """Percentage, voltage and word; a gauge with the threshold marked; what the charge does."""

    number, title_text = 1, "Battery"
    keys = (("charge", "charge"),)

    def compose(self) -> ComposeResult:
        yield Line(id="battery-line")
        yield Line(id="battery-gauge")
        yield Line(id="battery-history")
        yield Line(id="battery-trend")

    def show(self, view: View) -> None:
        snapshot, battery = view.snapshot, view.snapshot.battery
        bar = self.query_one("#battery-gauge", Line)
        width = max(bar.size.width, 1)
        line = words.battery_line(snapshot, view.now, width)
        self.query_one("#battery-line", Line).show(line)
        style = words.battery_word(snapshot)[2]
        if battery.received is None or battery.is_old(view.now):
            style = words.OLD
        text = words.gauge(battery.percentage, snapshot.threshold, width)
        bar.show(Content.styled(text, style))
        history = trend.sparkline(snapshot.charge, width)
        self.query_one("#battery-history", Line).show(Content.styled(history, words.OLD))
        does = words.battery_trend(snapshot, view.now, width)
        self.query_one("#battery-trend", Line).show(does)
        self.show_keys(view, f"low {snapshot.threshold:g}")
