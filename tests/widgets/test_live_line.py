"""The line over a replay: what the live robot does, and whether it needs somebody."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rich.cells import cell_len

from archo_tui.screens.replay import live_line
from archo_tui.station.alarms import AlarmState
from archo_tui.widgets.screen_state import ScreenState
from tests.support.states import STATES
from tests.support.stub import stub_app


def view_of(state: str, alarms: AlarmState | None = None) -> ScreenState:
    """Return what the console shows in a state; its alarms are all in the given state."""
    app = stub_app(STATES[state])
    app.station.on_snapshot(STATES[state])
    view = replace(app.view, **vars(app.station.view))
    if alarms is not None:
        view = replace(view, alarms=tuple(one._replace(state=alarms) for one in view.alarms))
    return view


def is_striking(view: ScreenState) -> bool:
    return any("reverse" in str(span.style) for span in live_line(view, 120).spans)


@pytest.mark.parametrize("width", [50, 80, 120, 200])
@pytest.mark.parametrize("state", STATES)
def test_it_says_live_and_the_key_that_leads_back_at_every_width(state: str, width: int) -> None:
    text = live_line(view_of(state), width).plain
    assert text.startswith(" LIVE ")
    assert text.endswith("q back ")
    assert cell_len(text) == width


def test_a_robot_that_is_stopped_is_striking_though_the_alarm_is_acknowledged() -> None:
    assert "STOPPED" in live_line(view_of("motor stopped"), 80).plain
    assert is_striking(view_of("motor stopped"))
    assert is_striking(view_of("motor stopped", AlarmState.ACKNOWLEDGED))
    assert not is_striking(view_of("motor moving"))


def test_further_alarms_are_counted_as_alarms() -> None:
    view = view_of("motor stopped")
    for count, said in ((2, "+1 more alarm "), (3, "+2 more alarms ")):
        assert said in live_line(replace(view, alarms=view.alarms[:1] * count), 160).plain


def test_an_alarm_that_is_over_is_not_told_as_one_that_lasts() -> None:
    view = view_of("motor stopped")
    over = tuple(one._replace(until=one.since + 5.0) for one in view.alarms)
    assert "▲ was: STOPPED" in live_line(replace(view, alarms=over), 120).plain


def test_an_alarm_that_is_cut_loses_no_digit_of_a_time() -> None:
    view = view_of("motor stopped")
    over = tuple(one._replace(until=one.since + 5.0) for one in view.alarms)
    for width in range(50, 120):
        text = live_line(replace(view, alarms=over), width).plain
        assert "…" not in text or "over" not in text, text
