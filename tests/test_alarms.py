"""Alarms as a table: conditions and times in, what stands in the banner out."""

from __future__ import annotations

from dataclasses import replace

import pytest

from archo_tui.alarms import CONTACT_LOST, EMPTY, LOW, STOPPED, AlarmBoard, conditions
from tests.console.states import BATTERY, MOTOR, NORMAL, STATES
from tests.support.stub import NOW


@pytest.mark.parametrize(
    ("state", "names"),
    [
        ("nothing heard yet", []),
        ("normal", []),
        ("battery low and moving", [LOW]),
        ("battery empty", [EMPTY]),
        ("battery charging", []),
        ("battery without health", [LOW]),
        ("battery not a number", []),
        ("battery old", []),
        ("contact lost", [CONTACT_LOST]),
        ("motor stopped", [STOPPED]),
    ],
)
def test_conditions_of_every_state(state: str, names: list[str]) -> None:
    assert sorted(conditions(STATES[state], NOW)) == names


def test_lost_contact_hides_what_was_last_heard() -> None:
    snapshot = replace(
        NORMAL,
        battery=replace(BATTERY, health="warning", received=NOW - 9),
        motor=replace(MOTOR, stopped=True, received=NOW - 9),
    )
    assert list(conditions(snapshot, NOW)) == [CONTACT_LOST]


def shown(board: AlarmBoard) -> tuple[str, bool, bool] | None:
    alarm = board.shown()
    return None if alarm is None else (alarm.name, alarm.is_over, alarm.acknowledged)


def test_an_alarm_goes_when_it_is_over_and_acknowledged() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop"}, 0, 100)
    assert shown(board) == (STOPPED, False, False)
    board.acknowledge()
    assert shown(board) == (STOPPED, False, True)
    board.update({}, 1, 101)
    assert shown(board) is None


def test_an_alarm_that_nobody_saw_stays_when_it_is_over() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop"}, 0, 100)
    board.update({}, 1, 101)
    assert shown(board) == (STOPPED, True, False)
    board.update({STOPPED: "stop"}, 2, 102)  # and again: a new alarm
    assert shown(board) == (STOPPED, False, False)
    board.update({}, 3, 103)
    board.acknowledge()
    assert shown(board) is None
    assert board.acknowledge() is None


def test_a_condition_must_hold_for_its_delay() -> None:
    board = AlarmBoard()
    board.update({LOW: "low"}, 0.0, 100)
    board.update({LOW: "low"}, 1.9, 101.9)
    assert shown(board) is None
    board.update({}, 1.95, 101.95)
    board.update({LOW: "low"}, 2.1, 102.1)  # counts anew
    assert shown(board) is None
    board.update({LOW: "low 2"}, 4.2, 104.2)
    assert shown(board) == (LOW, False, False)


def test_the_worst_unacknowledged_alarm_is_shown() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop", EMPTY: "empty"}, 0, 100)
    board.update({STOPPED: "stop", EMPTY: "empty"}, 5, 105)
    assert shown(board) == (EMPTY, False, False)
    board.acknowledge()
    assert shown(board) == (STOPPED, False, False)
    assert len(board.all()) == 2


def test_the_text_follows_without_a_new_alarm() -> None:
    board = AlarmBoard()
    board.update({EMPTY: "a"}, 0, 100)
    board.update({EMPTY: "a"}, 5, 105)
    board.acknowledge()
    board.update({EMPTY: "b"}, 6, 106)
    alarm = board.shown()
    assert alarm is not None
    assert (alarm.text, alarm.acknowledged, alarm.since) == ("b", True, 105)
