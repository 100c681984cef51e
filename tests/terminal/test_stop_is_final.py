"""The last STOP is final: whatever was typed before it, in real bytes through a terminal."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from archo_tui.robot.stop.gate import NOT_SENT
from tests.support.night import corners
from tests.support.terminal import Start, Terminal, said, until_said
from tests.support.waiting import wait_until

ROBOTS = Path(__file__).parent.parent / "robots"
CART = ("--only", "--node", str(ROBOTS / "cart.py"), "--robot", str(ROBOTS / "cart.yaml"))
pytestmark = pytest.mark.real_time
SLOW = ("--ros-args", "-p", "route_length:=1000.0", "-p", "time_scale:=1.0")


def stopped_archo(start: Start) -> Terminal:
    terminal = start()
    terminal.write("\x18")
    terminal.until("R releases")
    return terminal


@pytest.mark.parametrize("typed", corners(["R\t\r\x18"], ["Ry\x18"]))
def test_a_release_typed_before_a_stop_is_not_sent(typed: str, start: Start) -> None:
    terminal = stopped_archo(start)
    terminal.write(typed)
    until_said(NOT_SENT)
    terminal.write("\x18")
    terminal.write("\x11")  # a letter may still be for the question
    assert terminal.exit_code() == 0
    assert not [text for text in said() if "Released" in text]


def test_a_release_typed_behind_a_stop_is_sent(start: Start) -> None:
    terminal = stopped_archo(start)
    terminal.write("\x18Ry")
    until_said("release stop: Released")
    terminal.write("q")
    assert terminal.exit_code() == 0


@pytest.mark.parametrize("typed", ["g12\r\t\x18", "g12\t\r\x18"])  # By enter, and by Go.
def test_a_goal_sent_by_enter_or_a_button_never_drives_behind_a_stop(
    typed: str, start: Start
) -> None:
    terminal = start(*SLOW, shows="● motor_controller")
    terminal.write(typed)
    until_said("STOP: confirmed", f"go to shelf 12: {NOT_SENT}")
    terminal.until("R releases")
    terminal.until(NOT_SENT)  # the journal has it sooner than the queue
    terminal.write("\x1b")
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert not [text for text in said() if "accepted" in text]


def test_a_goal_and_a_command_typed_before_a_stop_are_not_sent(start: Start) -> None:
    terminal = start(*CART, shows="80.0 %")
    terminal.until("Blink")
    terminal.until("online")
    terminal.write("g12\r\x18")
    until_said("STOP: confirmed", f"go to shelf 12: {NOT_SENT}")
    terminal.until(NOT_SENT)  # the journal has it sooner than the queue
    terminal.write("g5\r")
    until_said("drives to 5")
    terminal.write("\x18")
    # whichever the cart takes first: STOP, or the cancel of a goal that it accepts behind STOP
    ended = re.compile("shelf 5 (aborted|cancelled)")
    wait_until(lambda: any(map(ended.search, said())), ended.pattern)
    terminal.write("b\x18")
    until_said(f"blink: {NOT_SENT}")
    terminal.write("b")
    until_said("blinked")
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert [text for text in said() if "drives" in text] == ["drives to 5"]
    assert said().count("blinked") == 1


def test_a_stop_right_before_the_end_is_sent(start: Start) -> None:
    terminal = start()
    terminal.write("\x18\x11")
    assert terminal.exit_code() == 0
    assert "STOP: confirmed" in said()
    assert "never awaited" not in terminal.text


def test_a_command_right_before_the_end_is_carried_out(start: Start) -> None:
    terminal = start()
    terminal.until("discharging")  # what c inverts was heard
    terminal.write("c\x11")
    assert terminal.exit_code() == 0
    assert "charge: Charging" in said()
