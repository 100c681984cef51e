"""The panel of the battery: how full, how healthy."""

from __future__ import annotations

from textual.app import ComposeResult

from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.widgets.line import Line, aligned
from archo_tui.screen.widgets.panel import Panel, ScreenState
from archo_tui.text.plot import sparkline, time_left_text
from archo_tui.text.state import (
    ACTIVE,
    OLD,
    PLAIN,
    WARN,
    Spans,
    age_text,
    battery_line,
    battery_word,
    charge_bar,
    fault_text,
    no_reading_reason,
)


class BatteryPanel(Panel, can_focus=True):
    """The panel with voltage, charge, a bar, a sparkline, and the time until empty or full."""

    title_text, verbs, place = "Battery", ("status",), "left"

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        robot = snapshot.file
        self._topic = "" if robot.battery is None else robot.battery.topic
        ours = [c for c in robot.commands if c.toggles_reading_of("battery")]
        self.keys = tuple((command.id, command.title.lower()) for command in ours)
        self._line, self._gauge = Line(id="battery-line"), Line(id="battery-gauge")
        self._history, self._trend = Line(id="battery-history"), Line(id="battery-trend")

    def compose(self) -> ComposeResult:
        yield from (self._line, self._gauge, self._history, self._trend)

    def show(self, view: ScreenState) -> None:
        snapshot, battery = view.snapshot, view.snapshot.battery
        width = max(self._gauge.size.width, 1)
        line = battery_line(snapshot, view.now, width)
        self._line.show_spans(aligned(line, width))
        tone = battery_word(snapshot)[2]
        if battery.received is None or battery.is_old(view.now):
            tone = OLD
        tone = ACTIVE if tone == PLAIN else tone
        bar = charge_bar(battery.percentage, snapshot.low_charge, width, tone)
        self._gauge.show_spans(bar)
        if self.is_news(snapshot.charge, width):  # Once a second, however fast readings come.
            self._history.show_spans(((sparkline(snapshot.charge, width), OLD),))
        self._trend.show_spans(_trend(snapshot, view.now, width))
        self.show_publishers(view, self._topic)
        low = snapshot.low_charge
        self.show_keys(view, "" if low is None else f"low {low:g}")


def _trend(snapshot: Snapshot, now: float, width: int) -> Spans:
    """Return what the charge does and when the battery is empty or full, or why it is not known."""
    battery = snapshot.battery
    if battery.received is None:
        described = snapshot.file.battery
        is_fault = described is not None and described.topic in snapshot.faults
        reason = no_reading_reason(snapshot)
        return ((fault_text(reason, width), WARN) if is_fault else (reason, OLD),)
    if battery.is_old(now):
        return ((f"last heard {age_text(now - battery.received)} ago", OLD),)
    if battery.unreadable:
        return (("not within 0 .. 100 %", WARN),)
    if battery.charging is None:
        return (("charging: not reported", OLD),)
    if not battery.charging and battery.discharging is False:
        neither = "neither charging nor discharging"
        return ((neither if len(neither) <= width else "not charging", PLAIN),)
    does = "charging" if battery.charging else "discharging"
    empty = battery.percentage is not None and battery.percentage <= 0 and not battery.charging
    end = "" if empty else time_left_text(snapshot.charge, charging=battery.charging)
    both = f"{does}, {end}"
    return (((both if len(both) <= width else end) if end else does, PLAIN),)
