"""Of a grave alarm somebody hears who looks elsewhere: once, and only where that can be."""

from __future__ import annotations

import pytest

from archo_tui.station.alarms import Alarm, AlarmBell, AlarmState
from archo_tui.station.conditions import CONTACT_LOST, LOW_BATTERY
from archo_tui.terminal.notification import desktop_notification
from tests.support.terminal import Terminal


def test_a_grave_alarm_is_news_once_until_it_is_gone() -> None:
    bell, grave = AlarmBell(), Alarm(CONTACT_LOST, "", 0.0)
    assert bell.take_new([grave, Alarm(LOW_BATTERY, "", 0.0)]) == [grave]
    over = Alarm(CONTACT_LOST, "", 0.0, AlarmState.RETURNED)
    for standing in (grave, over, grave, Alarm(CONTACT_LOST, "", 0.0, AlarmState.ACKNOWLEDGED)):
        assert bell.take_new([standing]) == []
    assert bell.take_new([]) == []
    assert bell.take_new([grave]) == [grave]


@pytest.mark.parametrize(
    ("environ", "written"),
    [
        ({"TERM": "xterm-kitty"}, "\x1b]99;;archo-tui: a, b\x1b\\"),
        ({"TERM_PROGRAM": "WezTerm"}, "\x1b]9;archo-tui: a, b\x07"),
        ({"TERM": "foot"}, "\x1b]777;notify;archo-tui;a, b\x1b\\"),
        ({"TERM": "xterm-256color", "VTE_VERSION": "7600"}, "\x1b]777;notify;archo-tui;a, b\x1b\\"),
        ({"TERM": "tmux-256color", "TERM_PROGRAM": "WezTerm"}, ""),
        ({"TERM": "xterm-256color"}, ""),
    ],
)
def test_a_notice_is_written_as_the_terminal_knows_it(
    environ: dict[str, str], written: str
) -> None:
    assert desktop_notification("a; b", environ) == written


def test_a_notice_holds_nothing_that_the_terminal_acts_on() -> None:
    made = desktop_notification("a\x07\x1b]0;b", {"TERM": "xterm-kitty"})
    assert (
        made == "\x1b]99;;archo-tui: a\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}]0,b\x1b\\"
    )


@pytest.mark.real_time
@pytest.mark.parametrize("words", [(), ("--quiet-alarms",)])
def test_the_terminal_rings_once_for_an_empty_battery(words: tuple[str, ...]) -> None:
    drain = ("-p", "drain_min:=50.0", "-p", "drain_max:=60.0", "-p", "publish_period:=0.1")
    terminal = Terminal(*words, "--ros-args", *drain, term="xterm-kitty")
    terminal.until("BATTERY EMPTY")
    terminal.write("q")
    assert terminal.exit_code() == 0
    terminal.close()
    rung = terminal.output.count(b"\x07\x1b]99;;archo-tui: BATTERY EMPTY")  # the bell first
    assert rung == (0 if words else 1)
