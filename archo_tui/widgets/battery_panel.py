"""Panel 1: how full, how healthy."""

from __future__ import annotations

from textual.app import ComposeResult

from archo_tui import state_text
from archo_tui.robot.state import Snapshot
from archo_tui.robots.model import Robot
from archo_tui.widgets import trend
from archo_tui.widgets.line import Line
from archo_tui.widgets.panel import Panel
from archo_tui.widgets.shown import Shown
from archo_tui.widgets.styled import content


class BatteryPanel(Panel, can_focus=True):
    """Percentage, voltage and word; a gauge with the threshold marked; what the charge does."""

    number, title_text = 1, "Battery"

    def __init__(self, robot: Robot) -> None:
        super().__init__()
        self._topic = "" if robot.battery is None else robot.battery.topic
        ours = [c for c in robot.commands if c.is_about("battery")]
        self.keys = tuple((command.id, command.title.lower()) for command in ours)
        self._line, self._gauge = Line(id="battery-line"), Line(id="battery-gauge")
        self._history, self._trend = Line(id="battery-history"), Line(id="battery-trend")

    def compose(self) -> ComposeResult:
        yield from (self._line, self._gauge, self._history, self._trend)

    def show(self, view: Shown) -> None:
        snapshot, battery = view.snapshot, view.snapshot.battery
        width = max(self._gauge.size.width, 1)
        line = state_text.battery_line(snapshot, view.now, width)
        self._line.show(content(line))
        tone = state_text.battery_word(snapshot)[2]
        if battery.received is None or battery.is_old(view.now):
            tone = state_text.OLD
        tone = state_text.ACTIVE if tone == state_text.PLAIN else tone
        gauge = state_text.gauge(battery.percentage, snapshot.threshold, width, tone)
        self._gauge.show(content(gauge))
        history = trend.sparkline(snapshot.charge, width)
        self._history.show(content(((history, state_text.OLD),)))
        self._trend.show(content(_trend(snapshot, view.now, width)))
        self.show_publishers(view, self._topic)
        low = snapshot.threshold
        self.show_keys(view, "" if low is None else f"low {low:g}")


def _trend(snapshot: Snapshot, now: float, width: int) -> state_text.Spans:
    """What the charge does, and when it will be empty or full."""
    battery = snapshot.battery
    if battery.received is None:
        return ((state_text.battery_source(snapshot), state_text.OLD),)
    if battery.is_old(now):
        return ((f"last heard {state_text.age(now - battery.received)} ago", state_text.OLD),)
    if battery.unreadable:
        return (("no percentage within 0 .. 100", state_text.WARN),)
    if battery.charging is None:
        return (("charging: not reported", state_text.OLD),)
    does = "charging" if battery.charging else "discharging"
    empty = battery.percentage is not None and battery.percentage <= 0 and not battery.charging
    end = "" if empty else trend.end_text(snapshot.charge, charging=battery.charging)
    both = f"{does}, {end}"
    return (((both if len(both) <= width else end) if end else does, state_text.PLAIN),)
