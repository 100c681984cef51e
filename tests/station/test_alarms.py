"""Alarms as a table: conditions, times and keys in, states and what stands in the banner out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.clock import time_of_day
from archo_tui.commands.alarms import AlarmRow, alarm_lines
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state.frames import Frame, Transforms
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.robot.state.snapshot import Hosted, Latch, Life, OpenStop, Snapshot, StopAnswer
from archo_tui.robot_file.model import FrameRule, TopicRule
from archo_tui.station import conditions as every
from archo_tui.station.alarms import (
    SHELF_TIME,
    TRANSITIONS,
    AlarmBell,
    AlarmBoard,
    AlarmState,
    Change,
    remedy_hints,
)
from archo_tui.station.conditions import (
    BATTERY_EMPTY,
    CONTACT_LOST,
    LOW_BATTERY,
    STOPPED,
    Priority,
    Situation,
    kind_of,
    open_stop_texts,
)
from archo_tui.station.history import History
from archo_tui.station.view import View
from archo_tui.widgets.bars import banner, header
from archo_tui.widgets.panel import ScreenState
from tests.support.alarms import conditions
from tests.support.clock import NOW
from tests.support.states import BATTERY, MOTOR, NORMAL, STATES


@pytest.mark.parametrize(
    ("state", "names"),
    [
        ("nothing heard yet", []),
        ("normal", []),
        ("battery low and moving", [LOW_BATTERY]),
        ("battery empty", [BATTERY_EMPTY]),
        ("battery charging", []),
        ("battery without health", [LOW_BATTERY]),
        ("battery to be replaced", ["battery health"]),
        ("battery with an unknown word", ["battery health"]),
        ("battery not a number", []),
        ("battery old", []),
        ("contact lost", [CONTACT_LOST]),
        ("motor stopped", [STOPPED]),
        ("motor stop not confirmed", ["stop not confirmed"]),
    ],
)
def test_conditions_of_every_state(state: str, names: list[str]) -> None:
    assert sorted(conditions(STATES[state], NOW)) == names


def test_an_empty_battery_refuses_moves_only_where_the_robot_file_says_so() -> None:
    empty = STATES["battery empty"]
    refuses = "BATTERY EMPTY: the robot refuses moves, charge it where it stands"
    assert conditions(empty, NOW) == {BATTERY_EMPTY: refuses}
    assert empty.file.battery is not None
    drives_on = replace(empty.file.battery, empty_refuses_moves=False)
    other = empty._replace(file=replace(empty.file, battery=drives_on))
    assert conditions(other, NOW) == {BATTERY_EMPTY: "BATTERY EMPTY: charge it"}


def test_a_good_word_says_nothing_against_a_low_percentage() -> None:
    empty = NORMAL._replace(battery=BATTERY._replace(percentage=3.0, health="good"))
    assert conditions(empty, NOW) == {LOW_BATTERY: "LOW BATTERY 3.0 %: dock the robot"}


def test_a_battery_to_be_replaced_is_an_alarm_and_low_by_its_percentage() -> None:
    low = NORMAL._replace(battery=BATTERY._replace(percentage=12.0, health="replace"))
    assert conditions(low, NOW) == {
        LOW_BATTERY: "LOW BATTERY 12.0 %: dock the robot",
        "battery health": "BATTERY HEALTH replace: have the battery replaced",
    }


SIMULATED = Parameter("/motor_controller", "use_sim_time", "bool", True, False)


def test_nobody_on_the_graph_is_an_alarm_that_says_where_was_looked() -> None:
    nobody, where = Snapshot(file=NORMAL.file), "on domain 7: try this"
    found = conditions(nobody, NOW, unseen=where)
    assert found == {"no nodes": f"NO NODES {where}"}
    for seen in (
        nobody._replace(nodes=NORMAL.nodes),
        nobody._replace(other_namespaces=("/north",)),  # the header says where
        nobody._replace(battery=BATTERY._replace(received=NOW - 9.0)),  # its contact is lost
    ):
        assert "no nodes" not in conditions(seen, NOW, unseen=where)
    heard = nobody._replace(battery=BATTERY._replace(received=NOW))
    again = "NO NODE NAMES, though the robot is heard: start this console again"
    assert conditions(heard, NOW, unseen=where)["no nodes"] == again
    stopped = (Hosted("/a", Life.STOPPED),)
    assert conditions(nobody, NOW, stopped, unseen=where) == {}  # the operator's own doing


def test_simulated_time_without_a_clock_is_an_alarm_that_names_the_nodes() -> None:
    other = SIMULATED._replace(node="/dashboard")
    simulated = NORMAL._replace(parameters=(*NORMAL.parameters, other, SIMULATED))
    found = conditions(simulated, NOW)
    assert list(found) == ["no clock"]
    assert found["no clock"].startswith("NO CLOCK for /dashboard, /motor_controller: use_sim_time")
    assert conditions(simulated._replace(has_clock=True), NOW) == {}
    off = SIMULATED._replace(value=False)
    assert conditions(NORMAL._replace(parameters=(off,)), NOW) == {}


def test_a_crashed_node_is_an_alarm_of_its_own() -> None:
    hosted = (Hosted("/a", Life.CRASHED, "boom"), Hosted("/b"), Hosted("/c", Life.STOPPED))
    assert list(conditions(NORMAL, NOW, hosted)) == ["node crashed /a"]


@pytest.mark.parametrize(
    ("goals", "said"),
    [
        (("shelf 12",), "shelf 12 STILL RUNS: use the hardware stop"),
        (("shelf 12", "another client's goal"), "STILL RUN: use the hardware stop   +1 alarm"),
    ],
)
def test_what_moves_on_after_a_stop_was_answered_is_the_gravest_alarm(
    goals: tuple[str, ...], said: str
) -> None:
    board = AlarmBoard()
    found = conditions(
        NORMAL._replace(still_running_after_stop=goals, open_stop=OpenStop(NOW - 3)), NOW
    )
    board.update(found, 0, 100)
    board.update(found, 3, 103)
    assert [alarm.name for alarm in board.all()] == ["moves after stop", "stop not confirmed"]
    assert shown(board).startswith("✗ STOP WAS ANSWERED")
    assert said in shown(board)


def test_lost_contact_hides_what_was_last_heard() -> None:
    snapshot = NORMAL._replace(
        battery=BATTERY._replace(health="warning", received=NOW - 9),
        motion=replace(MOTOR, stopped=True, received=NOW - 9),
    )
    assert list(conditions(snapshot, NOW)) == [CONTACT_LOST]


# the whole state machine: state, what happens, state afterwards (all else changes nothing)
N, U, A = AlarmState.NORMAL, AlarmState.UNACKNOWLEDGED, AlarmState.ACKNOWLEDGED
O, S, R = AlarmState.RETURNED, AlarmState.SHELVED, AlarmState.REPLACED  # noqa: E741
TABLE = {
    N: {Change.RAISED: U},
    U: {Change.CLEARED: O, Change.ACKNOWLEDGE: A, Change.SHELVE: S, Change.REPLACED: R},
    A: {Change.CLEARED: N, Change.SHELVE: S, Change.REPLACED: R},
    O: {Change.RAISED: U, Change.ACKNOWLEDGE: N, Change.SHELVE: S},
    S: {Change.UNSHELVE: N},
    R: {},
}


@pytest.mark.parametrize("state", AlarmState)
@pytest.mark.parametrize("change", Change)
def test_the_state_machine(state: AlarmState, change: Change) -> None:
    assert TRANSITIONS.get((state, change), state) == TABLE[state].get(change, state)


def reach(state: AlarmState) -> AlarmBoard:
    """A board whose one alarm is in that state, by the way an operator gets there."""
    board = AlarmBoard()
    if state == AlarmState.NORMAL:
        return board
    board.update({STOPPED: "stop: look"}, 0, 100)
    if state == AlarmState.ACKNOWLEDGED:
        board.acknowledge(board.all()[0], 100)
    if state == AlarmState.SHELVED:
        board.shelve(board.all()[0], 0, 100)
    if state == AlarmState.RETURNED:
        board.update({}, 1, 101)
    return board


@pytest.mark.parametrize("state", AlarmState)
def test_the_board_keeps_to_the_machine(state: AlarmState) -> None:
    def now(board: AlarmBoard) -> AlarmState:
        return board.all()[0].state if board.all() else AlarmState.NORMAL

    for change, after in TABLE[state].items():
        if change == Change.REPLACED:
            continue  # of a low battery only: see there
        board = reach(state)
        assert now(board) == state
        if change == Change.RAISED:
            changed = board.update({STOPPED: "stop: look"}, 2, 102)
        elif change == Change.CLEARED:
            changed = board.update({}, 2, 102)
        elif change == Change.ACKNOWLEDGE:
            changed = board.acknowledge(board.all()[0], 102)
        else:
            changed = board.shelve(board.all()[0], 2, 102)
        assert now(board) == after, change
        assert [alarm.state for alarm in changed] == [after]


def shown(board: AlarmBoard) -> str:
    view = ScreenState(
        NORMAL, NOW, NOW, 0.0, "embedded", "/", History(), board.all(), keys={"ack": "a"}
    )
    return banner(view, 80).plain.strip()


def test_the_banner_says_what_to_do_what_was_and_how_many_more() -> None:
    board = AlarmBoard()
    assert shown(board) == ""
    board.update({STOPPED: "STOPPED: look"}, 0, 100)
    assert shown(board) == "▲ STOPPED: look   (a acknowledge)"
    board.update({STOPPED: "STOPPED: look", CONTACT_LOST: "CONTACT LOST: wait"}, 1, 101)
    assert shown(board) == "✗ CONTACT LOST: wait   +1 alarm   (a acknowledge)"
    board.acknowledge(board.all()[0], 102)
    assert shown(board) == "▲ STOPPED: look   +1 alarm   (a acknowledge)"
    board.update({CONTACT_LOST: "CONTACT LOST: wait"}, 3, 103)
    assert shown(board) == "▲ STOPPED: look (last known)   +1 alarm   (a acknowledge)"
    board.shelve(next(alarm for alarm in board.all() if alarm.name == STOPPED), 4, 104)
    assert shown(board) == "✗ CONTACT LOST: wait   shelved: stopped"


def test_a_banner_without_room_keeps_what_to_do_and_how_many_more() -> None:
    board = AlarmBoard()
    found = conditions(NORMAL._replace(open_stop=OpenStop(NOW - 12)), NOW)
    for time in (0, 3):
        board.update({**found, BATTERY_EMPTY: "BATTERY EMPTY"}, time, 100)
    assert shown(board).startswith("✗ STOP SENT, no ")
    assert shown(board).endswith(": use the hardware stop   +1 alarm   (a)")


def test_an_alarm_that_is_over_says_from_when_to_when() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "STOPPED AT 12:04: look"}, 0, 100)
    board.update({}, 1, 101)
    assert shown(board).startswith("▲ was: STOPPED AT 12:04, since ")


def test_an_alarm_that_stands_comes_before_a_graver_one_that_is_over() -> None:
    board = AlarmBoard()
    board.update({CONTACT_LOST: "CONTACT LOST: wait"}, 0, 100)
    board.update({STOPPED: "STOPPED: look"}, 1, 101)
    assert [(alarm.name, alarm.is_over) for alarm in board.all()] == [
        (STOPPED, False),
        (CONTACT_LOST, True),
    ]
    assert shown(board) == "▲ STOPPED: look   +1 alarm   (a acknowledge)"


def test_a_gap_in_contact_changes_nothing_about_what_the_robot_said() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop"}, 0, 100)
    board.acknowledge(board.all()[0], 101)
    board.update({CONTACT_LOST: "lost"}, 2, 102)
    stopped = next(alarm for alarm in board.all() if alarm.name == STOPPED)
    assert (stopped.state, stopped.text) == (AlarmState.ACKNOWLEDGED, "stop (last known)")
    assert board.update({STOPPED: "stop"}, 3, 103) == [
        alarm for alarm in board.all() if alarm.name == CONTACT_LOST
    ]
    stopped = next(alarm for alarm in board.all() if alarm.name == STOPPED)
    assert (stopped.state, stopped.text, stopped.since) == (AlarmState.ACKNOWLEDGED, "stop", 100)


def test_a_stop_that_is_known_to_be_over_is_not_kept_as_last_known() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop"}, 0, 100)
    for time, over, is_over in ((2, (), False), (3, (STOPPED,), True)):
        board.update({CONTACT_LOST: "lost"}, time, 100 + time, over)
        stopped = next(alarm for alarm in board.all() if alarm.name == STOPPED)
        assert stopped.is_over == is_over


def test_a_goal_that_says_nothing_is_an_alarm_unless_the_motor_is_silent() -> None:
    moving = STATES["motor moving"]
    goal = moving.goal._replace(phase=Phase.LOST, heard=NOW - 6)  # type: ignore[union-attr]
    found = conditions(moving._replace(goal=goal), NOW)
    assert found == {
        "no word of the goal": "NO WORD FROM GO TO SHELF for 6 s: the robot may still be driving"
    }
    silent = moving._replace(goal=goal, motion=replace(MOTOR, received=NOW - 6))
    assert list(conditions(silent, NOW)) == ["motor silent"]


def test_a_motor_that_falls_silent_in_a_move_is_an_alarm_of_its_own() -> None:
    silent = STATES["motor moving"]._replace(motion=replace(MOTOR, received=NOW - 3))
    found = conditions(silent, NOW)
    assert list(found) == ["motor silent"]
    assert found["motor silent"] == (
        "motor_status silent for 3 s while moving: the robot may still be driving"
    )
    resting = NORMAL._replace(motion=replace(MOTOR, received=NOW - 3))
    assert list(conditions(resting, NOW)) == []


def test_a_condition_must_hold_for_its_delay() -> None:
    board = AlarmBoard()
    board.update({LOW_BATTERY: "low"}, 0.0, 100)
    board.update({LOW_BATTERY: "low"}, 1.9, 101.9)
    assert board.all() == ()
    board.update({}, 1.95, 101.95)
    board.update({LOW_BATTERY: "low"}, 2.1, 102.1)  # counts anew
    assert board.all() == ()
    board.update({LOW_BATTERY: "low 2"}, 4.2, 104.2)
    assert [alarm.text for alarm in board.all()] == ["low 2"]


def test_the_text_follows_without_a_new_alarm() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "a"}, 0, 100)
    board.acknowledge(board.all()[0], 101)
    assert board.update({STOPPED: "b"}, 6, 106) == []
    (alarm,) = board.all()
    assert (alarm.text, alarm.acknowledged, alarm.since) == ("b", True, 100)


def test_a_shelved_alarm_comes_back_after_its_time_if_it_still_holds() -> None:
    board = reach(AlarmState.SHELVED)
    board.update({STOPPED: "stop"}, SHELF_TIME - 1, 100 + SHELF_TIME - 1)
    assert [alarm.state for alarm in board.all()] == [AlarmState.SHELVED]
    board.update({STOPPED: "stop"}, SHELF_TIME, 100 + SHELF_TIME)
    assert [alarm.state for alarm in board.all()] == [AlarmState.UNACKNOWLEDGED]


@pytest.mark.parametrize("by", [-90_000, 90_000])
def test_a_clock_that_is_set_leaves_an_alarm_shelved_for_its_time(by: int) -> None:
    board = reach(AlarmState.SHELVED)
    board.update({STOPPED: "stop"}, SHELF_TIME - 60, 100 + by + SHELF_TIME - 60)
    (shelved,) = board.all()
    assert shelved.state == AlarmState.SHELVED
    lines = [text for text, _ in alarm_lines(AlarmRow(shelved, shelved.text), 80, ())]
    assert f"until {time_of_day(100 + by + SHELF_TIME)}" in lines[0]
    board.update({STOPPED: "stop"}, SHELF_TIME, 100 + by + SHELF_TIME)
    assert [alarm.state for alarm in board.all()] == [AlarmState.UNACKNOWLEDGED]


def test_an_alarm_that_is_gone_is_neither_acknowledged_nor_shelved() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop"}, 0, 0)
    seen = board.all()[0]
    board.acknowledge(seen, 1)
    board.update({}, 2, 2)
    assert board.all() == ()
    assert board.acknowledge(seen, 3) == []
    assert board.shelve(seen, 3, 3) == []
    assert board.all() == ()


def test_a_shelved_alarm_that_is_over_goes_after_its_time() -> None:
    board = reach(AlarmState.SHELVED)
    board.update({}, 5, 105)
    assert [alarm.state for alarm in board.all()] == [AlarmState.SHELVED]
    board.update({STOPPED: "again"}, 6, 106)  # does not disturb
    board.update({}, 7, 107)
    board.update({}, SHELF_TIME, 100 + SHELF_TIME)
    assert board.all() == ()


def test_the_banner_names_the_key_of_what_can_be_done_now() -> None:
    board = AlarmBoard()
    board.update({LOW_BATTERY: "LOW BATTERY 18.0 %: dock the robot"}, 0, 100)
    board.update({LOW_BATTERY: "LOW BATTERY 18.0 %: dock the robot"}, 3, 103)
    keys = {"ack": "a", "charge": "c"}
    view = ScreenState(NORMAL, NOW, NOW, 0.0, "embedded", "/", History(), board.all(), keys=keys)
    assert "dock the robot, or press c to charge" in banner(view, 120).plain
    nobody_charges = replace(view, blocked=frozenset({"charge"}))
    assert "press c" not in banner(nobody_charges, 120).plain


def test_the_header_of_a_robot_that_moves_on_does_not_say_stopped() -> None:
    stopped = STATES["motor stopped"]
    for moves, word in ((False, "✗ STOPPED"), (True, "✗ STILL MOVING")):
        snapshot = stopped._replace(stop_not_obeyed=moves)
        view = View(snapshot, NOW, NOW, 0.0, "embedded", "/", History())
        assert word in header(view, 120).plain


def test_the_header_names_what_is_silent_while_the_rest_is_heard() -> None:
    silent = NORMAL._replace(motion=replace(MOTOR, received=NOW - 4))
    view = View(silent, NOW, NOW, 0.0, "embedded", "/", History())
    assert "▲ motor_status silent, 4 s" in header(view, 80).plain
    assert "online" not in header(view, 80).plain
    assert "● online" in header(replace(view, snapshot=NORMAL), 80).plain


def test_a_low_battery_stays_an_alarm_until_it_counts_as_empty() -> None:
    board = AlarmBoard()
    low, empty = (
        {LOW_BATTERY: "LOW BATTERY 0.1 %: dock"},
        {BATTERY_EMPTY: "BATTERY EMPTY: charge it"},
    )
    board.update(low, 0, 100)
    board.update(low, 2, 102)
    board.acknowledge(board.all()[0], 103)
    for later in (3, 4):
        board.update(empty, later, 100 + later)
        assert [(alarm.name, alarm.is_over) for alarm in board.all()] == [(LOW_BATTERY, False)]
    changed = board.update(empty, 5, 105)
    assert [alarm.name for alarm in board.all()] == [BATTERY_EMPTY]
    assert [(alarm.name, alarm.state) for alarm in changed] == [
        (BATTERY_EMPTY, AlarmState.UNACKNOWLEDGED),
        (LOW_BATTERY, AlarmState.REPLACED),
    ]


def test_a_low_battery_that_was_over_is_one_again_when_it_falls_empty() -> None:
    board = AlarmBoard()
    low, empty = (
        {LOW_BATTERY: "LOW BATTERY 0.1 %: dock"},
        {BATTERY_EMPTY: "BATTERY EMPTY: charge it"},
    )
    board.update(low, 0, 100)
    board.update(low, 2, 102)
    board.update({}, 3, 103)  # it is being charged
    assert shown(board).startswith("▲ was: LOW BATTERY")
    board.update(empty, 4, 104)
    assert shown(board).startswith("▲ LOW BATTERY 0.1 %")
    board.update(empty, 6, 106)
    assert [alarm.name for alarm in board.all()] == [BATTERY_EMPTY]


def test_silence_while_the_console_was_suspended_is_no_alarm() -> None:
    board, lost = AlarmBoard(), {CONTACT_LOST: "CONTACT LOST for 6 s"}
    board.update({STOPPED: "STOPPED: look"}, 0, 100)
    board.update(lost, 6, 106)  # it was suspended in between
    assert shown(board).startswith("▲ STOPPED: look (last known)")
    board.update({STOPPED: "STOPPED: look"}, 7, 107)  # the robot is heard again
    assert shown(board) == "▲ STOPPED: look   (a acknowledge)"
    for later in (20, 21, 22, 22.5):
        board.update(lost, later, 100 + later)
    assert shown(board).startswith("✗ CONTACT LOST for 6 s")  # it is not


def test_a_console_that_stands_still_again_and_again_raises_lost_contact() -> None:
    board = AlarmBoard()
    for later in (0, 5, 10):
        board.update({CONTACT_LOST: "CONTACT LOST"} if later else {}, later, 100 + later)
    assert shown(board).startswith("✗ CONTACT LOST")


@pytest.mark.parametrize("acknowledged", [True, False])
def test_a_grave_alarm_that_comes_again_rings_again(acknowledged: bool) -> None:
    board, bell = AlarmBoard(), AlarmBell()
    board.update({CONTACT_LOST: "lost"}, 0, 100)
    assert len(bell.take_new(board.all())) == 1
    if acknowledged:
        board.acknowledge(board.all()[0], 101)
    board.update({CONTACT_LOST: "lost for 2 s"}, 2, 102)
    assert bell.take_new(board.all()) == []
    board.update({}, 3, 103)
    board.update({CONTACT_LOST: "lost"}, 4, 104)  # before anybody looked
    assert [alarm.name for alarm in bell.take_new(board.all())] == [CONTACT_LOST]


def test_a_grave_alarm_whose_shelf_ends_while_it_holds_rings_again() -> None:
    board, bell = AlarmBoard(), AlarmBell()
    board.update({CONTACT_LOST: "lost"}, 0, 100)
    assert len(bell.take_new(board.all())) == 1
    board.shelve(board.all()[0], 1, 101, "a test")
    for later, rings in (
        (2, 0),
        (597, 0),
        (SHELF_TIME, 0),
        (SHELF_TIME + 1, 1),
        (SHELF_TIME + 2, 0),
    ):
        board.update({CONTACT_LOST: "lost"}, later, 100 + later)
        assert len(bell.take_new(board.all())) == rings


def test_a_command_that_no_node_offers_is_not_advised() -> None:
    typed = {"charge": "type charge", "release": "type release"}
    assert set(remedy_hints(NORMAL, typed).values()) == {"type charge", "type release"}
    alone = NORMAL._replace(offered=NORMAL.offered - {"set_charging", "release_emergency_stop"})
    assert remedy_hints(alone, typed) == {}


@pytest.mark.parametrize(
    ("snapshot", "is_told"),
    [
        (NORMAL._replace(motion=replace(MOTOR, stopped=None)), True),
        (NORMAL, False),  # the robot says itself that it is not stopped
        (NORMAL._replace(motion=replace(MOTOR, stopped=None, moving=True)), False),
        (NORMAL._replace(motion=replace(MOTOR, stopped=None), released=NOW - 1.0), False),
        (NORMAL._replace(motion=replace(MOTOR, stopped=None), latch=Latch.HELD), False),
    ],
    ids=["not known", "reported", "moves", "released", "stopped since"],
)
def test_a_stop_from_before_the_start_is_told_until_something_is_known(
    snapshot: Snapshot, is_told: bool
) -> None:
    found = conditions(snapshot, NOW, earlier_stop=1_700_000_000.0)
    assert ("earlier stop" in found) is is_told
    assert not snapshot.is_stopped or not is_told


def part(name: str, level: DiagnosticLevel, **more: Any) -> Diagnostic:
    return Diagnostic(name, "", level, "words", **{"received": NOW, **more})


def test_each_part_that_is_not_ok_has_an_alarm_up_to_twenty() -> None:
    parts = (part("fan", DiagnosticLevel.OK), part("motor", DiagnosticLevel.ERROR))
    found = conditions(NORMAL._replace(diagnostics=parts), NOW)
    assert found == {"diagnostics error motor": "ERROR motor: words"}
    many = tuple(part(f"part {n:02}", DiagnosticLevel.WARN) for n in range(25))
    found = conditions(NORMAL._replace(diagnostics=many), NOW)
    assert len(found) == 21
    assert found["diagnostics others"] == "5 MORE PARTS ARE NOT OK: see diagnostics"


def test_a_stop_without_an_answer_is_not_said_to_be_a_silent_topic() -> None:
    stop = OpenStop(NOW - 7.0, StopAnswer.NONE)
    assert open_stop_texts(NORMAL, stop, NOW)[-1] == "STOP SENT, unanswered 7 s"


def test_a_part_has_its_alarm_though_another_of_its_name_is_well() -> None:
    parts = tuple(
        part("motor", level)._replace(hardware_id=where)
        for where, level in (("left", DiagnosticLevel.ERROR), ("right", DiagnosticLevel.OK))
    )
    found = conditions(NORMAL._replace(diagnostics=parts), NOW)
    assert found == {"diagnostics error motor (left)": "ERROR motor (left): words"}


def test_parts_that_all_fall_silent_are_one_alarm() -> None:
    parts = tuple(part(f"part {n}", DiagnosticLevel.OK, received=NOW - 9) for n in range(5))
    silent = NORMAL._replace(diagnostics=parts)
    silent = silent._replace(file=replace(silent.file, diagnostics="/diagnostics"))
    text = "DIAGNOSTICS STALE: nothing on /diagnostics for 9 s"
    assert conditions(silent, NOW) == {"diagnostics /diagnostics": text}


def test_a_part_that_is_bad_once_within_the_delay_raises_nothing() -> None:
    board = AlarmBoard()
    bad = {"diagnostics motor": "WARN motor: words"}
    for tenth in range(60):
        assert not board.update(bad if tenth < 15 else {}, tenth / 10, tenth / 10)


@pytest.mark.parametrize("name", ["diagnostics motor", "diagnostics error motor"])
def test_a_part_that_flaps_is_one_alarm_until_it_is_well(name: str) -> None:
    board = AlarmBoard()
    changes = []
    for second in range(20):
        changes += board.update({name: "words"} if second % 2 else {}, second, second)
    assert [(alarm.name, alarm.is_over) for alarm in changes] == [(name, False)]
    board.update({}, 21, 21)
    (alarm,) = board.all()
    assert alarm.is_over


def test_a_part_between_error_and_warning_has_its_error_alone() -> None:
    board = AlarmBoard()
    warning, error = {"diagnostics motor": "WARN"}, {"diagnostics error motor": "ERROR"}
    for half in range(30):
        board.update(error if half % 2 else warning, half / 2, half / 2)
        assert half < 8 or [alarm.name for alarm in board.all()] == ["diagnostics error motor"]
    for second in range(15, 20):
        board.update(warning, second, second)
    assert "diagnostics motor" in [alarm.name for alarm in board.all() if not alarm.is_over]


def test_a_part_whose_name_reads_like_another_alarm_is_in_quotes() -> None:
    parts = (
        part("motor", DiagnosticLevel.ERROR),
        part("error motor", DiagnosticLevel.WARN),
        part("others", DiagnosticLevel.WARN),
    )
    found = conditions(NORMAL._replace(diagnostics=parts), NOW)
    assert found == {
        "diagnostics error motor": "ERROR motor: words",
        'diagnostics "error motor"': "WARN error motor: words",
        'diagnostics "others"': "WARN others: words",
    }
    assert kind_of('diagnostics "error motor"').name == "diagnostics"


def test_a_part_that_reports_itself_stale_says_why() -> None:
    parts = (part("imu", DiagnosticLevel.STALE), part("gps", DiagnosticLevel.STALE))
    snapshot = NORMAL._replace(diagnostics=parts)
    assert conditions(snapshot, NOW)["diagnostics imu"] == "STALE imu: words"


def test_what_is_still_heard_of_parts_is_told_while_contact_is_lost() -> None:
    parts = (
        part("base driver", DiagnosticLevel.ERROR),
        part("lidar", DiagnosticLevel.ERROR, received=NOW - 60),
    )
    lost = NORMAL._replace(
        diagnostics=parts,
        battery=NORMAL.battery._replace(received=NOW - 60),
        motion=replace(NORMAL.motion, received=NOW - 60),
    )
    found = conditions(lost, NOW)
    assert list(found) == [CONTACT_LOST, "diagnostics error base driver"]


def test_an_error_takes_the_place_of_the_warning_of_its_part() -> None:
    board = AlarmBoard()
    warning, error = {"diagnostics motor": "WARN"}, {"diagnostics error motor": "ERROR"}
    for second in range(4):
        board.update(warning, second, second)
    board.update(error, 4, 4)
    assert [alarm.name for alarm in board.all()] == ["diagnostics motor"]
    board.update(error, 7, 7)
    (alarm,) = board.all()
    assert (alarm.name, alarm.priority) == ("diagnostics error motor", Priority.HIGH)


def board_at(snapshot: Snapshot, board: AlarmBoard, now: float, *, silent: bool = False) -> Any:
    """What stands on the board after a look: names, texts, and whether they are over."""
    battery = snapshot.battery if silent else snapshot.battery._replace(received=now)
    motion = replace(snapshot.motion, received=now)
    found = every.conditions(Situation(snapshot._replace(battery=battery, motion=motion), now))
    board.update(found.texts, now, now, (), found.unknown)
    return [(alarm.name, alarm.text, alarm.is_over) for alarm in board.all()]


@pytest.mark.parametrize("is_silent", [True, False])
def test_a_battery_that_is_not_known_any_more_is_as_empty_as_it_was(is_silent: bool) -> None:
    board, empty = AlarmBoard(), STATES["battery empty"]
    board_at(empty, board, NOW)
    ((name, text, _),) = board_at(empty, board, NOW + 3.0)
    assert name == BATTERY_EMPTY
    unknown = empty._replace(battery=empty.battery._replace(percentage=None))
    seen = board_at(empty if is_silent else unknown, board, NOW + 30.0, silent=is_silent)
    assert seen == [(name, f"{text} (last known)", False)]
    assert board_at(NORMAL, board, NOW + 31.0)[0][2]


def test_a_battery_that_is_low_between_unreadable_values_is_low() -> None:
    low, board = STATES["battery low and moving"], AlarmBoard()
    unreadable = low._replace(battery=low.battery._replace(percentage=None, health=None))
    for number in range(4):
        seen = board_at(low if number % 2 else unreadable, board, NOW + 0.6 * number)
    assert seen == []
    assert [name for name, _, _ in board_at(low, board, NOW + 3.0)] == [LOW_BATTERY]


def test_a_warning_beside_an_error_of_its_part_waits_for_its_own_delay() -> None:
    board = AlarmBoard()
    for now in (0.0, 2.0):
        board.update({"diagnostics error motor": "E"}, now, now)
    board.update({"diagnostics motor": "W"}, 2.5, 2.5)
    board.update({"diagnostics error motor": "E"}, 3.0, 3.0)
    board.update({}, 3.4, 3.4)
    raised = board.update({"diagnostics motor": "W"}, 5.1, 5.1)
    assert "diagnostics motor" not in [alarm.name for alarm in raised]


RATED = replace(NORMAL.file, topics=(TopicRule("scan", rate=10.0), TopicRule("words", rate=0.1)))


@pytest.mark.parametrize(
    ("interval", "ago", "said"),
    [
        (0.1, 0.1, {}),
        (0.12, 0.1, {}),  # 8.3 Hz
        (0.13, 0.1, {"slow": "/scan IS TOO SLOW, 7.7 Hz: expected 10 Hz, within 20%"}),
        (0.08, 0.1, {"fast": "/scan IS TOO FAST, 12.5 Hz: expected 10 Hz, within 20%"}),
        (0.13, 3.0, {"silent": "/scan IS SILENT for 3 s: expected 10 Hz"}),
        (None, 0.0, {"silent": "/scan IS SILENT: nothing came, expected 10 Hz"}),
    ],
)
def test_a_topic_that_is_not_as_often_as_expected_is_an_alarm(
    interval: float | None, ago: float, said: dict[str, str]
) -> None:
    rates = {"/words": MessageRate(NOW - 29.0)}
    if interval is not None:
        rates["/scan"] = MessageRate(NOW - ago, interval)
    snapshot = NORMAL._replace(file=RATED, message_rates=rates)
    found = conditions(snapshot, NOW)
    assert found == {f"topic {kind} /scan": text for kind, text in said.items()}
    assert kind_of(next(iter(found), "topic slow /scan")).name.startswith("topic ")


def test_a_slow_topic_that_becomes_fast_is_another_alarm() -> None:
    board, seen = AlarmBoard(), list[str]()
    for second in range(20):
        now, interval = NOW + second, 0.13 if second < 8 else 0.08
        rates = {"/scan": MessageRate(now, interval), "/words": MessageRate(now)}
        rated = NORMAL._replace(file=RATED, message_rates=rates)
        seen += [f"{name} {is_over}" for name, _, is_over in board_at(rated, board, now)]
    assert [*dict.fromkeys(text for text in seen if "/scan" in text)] == [
        *("topic slow /scan False", "topic slow /scan True", "topic fast /scan False")
    ]


@pytest.mark.parametrize(
    ("ago", "behind", "is_static", "said"),
    [
        (0.5, 0.1, False, ""),
        (9.0, 9.0, True, ""),
        (0.5, -9.0, False, ""),  # The list of transforms says that.
        (3.0, 0.1, False, "FRAME base_link IS SILENT for 3.0 s: expected within 1 s"),
        (0.5, 2.0, False, "FRAME base_link IS 2.5 s OLD by its stamp: expected within 1 s"),
        (
            None,
            0.0,
            False,
            "FRAME base_link IS SILENT: no transform to it came, expected within 1 s",
        ),
    ],
)
def test_a_frame_that_is_older_than_the_robot_file_allows_is_an_alarm(
    ago: float | None, behind: float, is_static: bool, said: str
) -> None:
    file, frames = replace(NORMAL.file, frames=(FrameRule("base_link", 1.0),)), {}
    if ago is not None:
        rate = MessageRate(NOW - ago)
        frames["base_link"] = Frame("base_link", "odom", {}, rate, behind, is_static)
    found = conditions(NORMAL._replace(file=file, transforms=Transforms(frames)), NOW)
    assert found == ({"frame silent base_link": said} if said else {})
    assert kind_of("frame silent base_link").priority is Priority.MED


def test_why_no_frame_can_be_read_stands_in_its_alarm() -> None:
    file = replace(NORMAL.file, frames=(FrameRule("base_link"),))
    unread = NORMAL._replace(file=file, transforms=Transforms(fault="/tf: not installed"))
    said = "FRAME base_link IS SILENT: /tf: not installed"
    assert conditions(unread, NOW) == {"frame silent base_link": said}
