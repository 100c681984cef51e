"""Alarms as a table: conditions, times and keys in, states and what stands in the banner out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.base.clock import time_of_day
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state.frames import Frame, Transforms
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.readings import Diagnostic, DiagnosticLevel
from archo_tui.robot.state.snapshot import Hosted, Latch, Life, OpenStop, Snapshot, StopAnswer
from archo_tui.robot_file.model import FrameRule, TopicRule
from archo_tui.screen.commands.alarms import AlarmRow, alarm_lines
from archo_tui.screen.widgets.bars import banner, header
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.station import conditions as every
from archo_tui.station.alarms import (
    SHELF_TIME,
    AlarmBell,
    AlarmBoard,
    AlarmState,
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
)
from archo_tui.station.history import History
from archo_tui.station.view import View
from tests.support.alarms import conditions
from tests.support.clock import NOW
from tests.support.states import BATTERY, MOTOR, MOVING, NORMAL, STATES, goal


def part(name: str, level: DiagnosticLevel, ago: float = 0.0, where: str = "") -> Diagnostic:
    return Diagnostic(name, where, level, "words", received=NOW - ago)


def parts(*found: Diagnostic) -> Snapshot:
    """A robot with diagnostics."""
    file = replace(NORMAL.file, diagnostics="/diagnostics")
    return NORMAL._replace(diagnostics=found, file=file)


def charged(**fields: Any) -> Snapshot:
    return NORMAL._replace(battery=BATTERY._replace(**fields))


OK, WARN, STALE, ERROR = (
    *(DiagnosticLevel.OK, DiagnosticLevel.WARN, DiagnosticLevel.STALE, DiagnosticLevel.ERROR),
)
EMPTY, MOVES = STATES["battery empty"], STATES["motor moving"]
assert EMPTY.file.battery is not None
DRIVES_ON = replace(EMPTY.file, battery=replace(EMPTY.file.battery, empty_refuses_moves=False))
LOST_GOAL = MOVING._replace(phase=Phase.LOST, heard=NOW - 6)
LONG_AGO: dict[str, Any] = {"battery": BATTERY._replace(health="warning", received=NOW - 60)}
LONG_AGO["motion"] = replace(MOTOR, stopped=True, received=NOW - 60)
IN_A_FRAME = replace(NORMAL.file, frames=(FrameRule("base_link"),))
CONDITIONS: dict[str, tuple[Snapshot, dict[str, str]]] = {
    "an empty battery, where the robot file says what that means": (
        EMPTY,
        {BATTERY_EMPTY: "BATTERY EMPTY: the robot refuses moves, charge it where it stands"},
    ),
    "and where it does not": (
        EMPTY._replace(file=DRIVES_ON),
        {BATTERY_EMPTY: "BATTERY EMPTY: charge it"},
    ),
    "a good word says nothing against a low percentage": (
        charged(percentage=3.0, health="good"),
        {LOW_BATTERY: "LOW BATTERY 3.0 %: dock the robot"},
    ),
    "a battery to be replaced may be low, too": (
        charged(percentage=12.0, health="replace"),
        {
            LOW_BATTERY: "LOW BATTERY 12.0 %: dock the robot",
            "battery health": "BATTERY HEALTH replace: have the battery replaced",
        },
    ),
    "a goal without a word": (
        MOVES._replace(goal=LOST_GOAL),
        {"no word of the goal": "NO WORD FROM GO TO SHELF for 6 s: the robot may still be driving"},
    ),
    "a robot that moves behind a STOP that is not confirmed": (
        MOVES._replace(open_stop=OpenStop(NOW - 3, StopAnswer.NONE)),
        {
            "moves after stop": "THE ROBOT MOVES ALTHOUGH STOP WAS SENT: use the hardware stop",
            "stop not confirmed": "STOP SENT, no answer for 3 s, sent again while the robot is "
            "heard: use the hardware stop",
        },
    ),
    "a robot that has not had the time to stand": (
        MOVES._replace(open_stop=OpenStop(NOW, StopAnswer.NONE)),
        {"stop not confirmed": "STOP SENT: use the hardware stop"},
    ),
    "of a motor that is silent too, one alarm is enough": (
        MOVES._replace(goal=LOST_GOAL, motion=replace(MOTOR, received=NOW - 6)),
        {
            "motor silent": "motor_status silent for 6 s while moving: "
            "the robot may still be driving"
        },
    ),
    "a silent motor at rest": (NORMAL._replace(motion=replace(MOTOR, received=NOW - 3)), {}),
    "lost contact hides what was last heard, but not what still is": (
        parts(part("base driver", ERROR), part("lidar", ERROR, 60))._replace(**LONG_AGO),
        {
            CONTACT_LOST: "CONTACT LOST for 60 s: the robot may still be moving",
            "diagnostics error base driver": "ERROR base driver: words",
        },
    ),
    "a frame that cannot be read": (
        NORMAL._replace(file=IN_A_FRAME, transforms=Transforms(fault="/tf: not installed")),
        {"frame silent base_link": "FRAME base_link IS SILENT: /tf: not installed"},
    ),
    "the part that is not OK": (
        parts(part("fan", OK), part("motor", ERROR)),
        {"diagnostics error motor": "ERROR motor: words"},
    ),
    "a part beside one of its name that is well": (
        parts(part("motor", ERROR, where="left"), part("motor", OK, where="right")),
        {"diagnostics error motor (left)": "ERROR motor (left): words"},
    ),
    "parts that all fall silent": (
        parts(*(part(f"part {n}", OK, 9) for n in range(5))),
        {"diagnostics /diagnostics": "DIAGNOSTICS STALE: nothing on /diagnostics for 9 s"},
    ),
    "parts whose names read like other alarms": (
        parts(part("motor", ERROR), part("error motor", WARN), part("others", WARN)),
        {
            "diagnostics error motor": "ERROR motor: words",
            'diagnostics "error motor"': "WARN error motor: words",
            'diagnostics "others"': "WARN others: words",
        },
    ),
    "a part that reports itself stale": (
        parts(part("imu", STALE), part("gps", OK)),
        {"diagnostics imu": "STALE imu: words"},
    ),
}
STATE_ALARMS = {
    "nothing heard yet": "",
    "normal": "",
    "battery low and moving": LOW_BATTERY,
    "battery charging": "",
    "battery without health": LOW_BATTERY,
    "battery with an unknown word": "battery health",
    "battery not a number": "",
    "battery old": "",
    "contact lost": CONTACT_LOST,
    "motor stopped": STOPPED,
    "motor stop not confirmed": "stop not confirmed",
}


@pytest.mark.parametrize("case", CONDITIONS)
def test_what_is_wrong_is_told(case: str) -> None:
    snapshot, told = CONDITIONS[case]
    assert conditions(snapshot, NOW) == told


def test_each_state_has_its_alarm() -> None:
    found = {state: " ".join(conditions(STATES[state], NOW)) for state in STATE_ALARMS}
    assert found == STATE_ALARMS
    hosted = (Hosted("/a", Life.CRASHED, "boom"), Hosted("/b"), Hosted("/c", Life.STOPPED))
    assert list(conditions(NORMAL, NOW, hosted)) == ["node crashed /a"]
    many = conditions(parts(*(part(f"part {n:02}", WARN) for n in range(25))), NOW)
    assert len(many) == 21
    assert many["diagnostics others"] == "5 MORE PARTS ARE NOT OK: see diagnostics"
    assert kind_of('diagnostics "error motor"').name == "diagnostics"


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


# Of each moment: what is found (or what the operator does), and what stands on the board then:
# ! unacknowledged, = acknowledged, ~ over and unacknowledged, # shelved; ? as it was last known.
SIGNS = {
    AlarmState.UNACKNOWLEDGED: "!",
    AlarmState.ACKNOWLEDGED: "=",
    AlarmState.RETURNED: "~",
    AlarmState.SHELVED: "#",
}
STORIES = {
    "an alarm is over and acknowledged before it goes": """
        0 stopped | !stopped
        1 | ~stopped
        2 ack |
        3 stopped | !stopped
        4 ack | =stopped
        5 |
        6 stopped | !stopped
        7 | ~stopped
        8 stopped | !stopped
        9 | ~stopped
        9 shelve | #stopped
        9 ack | #stopped
        9 unshelve |""",
    "one that stands comes before a graver one that is over": """
        0 contact lost | !contact lost
        1 stopped | !stopped, ~contact lost""",
    "a gap in contact changes nothing about what the robot said": """
        0 stopped | !stopped
        1 ack | =stopped
        2 contact lost | !contact lost, =stopped?
        3 stopped | ~contact lost, =stopped""",
    "a condition holds for its delay": """
        0 low battery |
        1.9 low battery |
        1.95 |
        2.1 low battery |
        4.2 low battery | !low battery""",
    "a shelved alarm comes back after its time": """
        0 stopped | !stopped
        0 shelve | #stopped
        599 stopped | #stopped
        600 stopped | !stopped""",
    "one that is over by then goes": """
        0 stopped | !stopped
        1 ack | =stopped
        1 shelve | #stopped
        5 | #stopped
        6 stopped | #stopped
        7 | #stopped
        601 |""",
    "a battery is low until it counts as empty": """
        0 low battery |
        2 low battery | !low battery
        3 ack | =low battery
        3 battery empty | =low battery
        4 battery empty | =low battery
        5 battery empty | !battery empty""",
    "and is low again if that was over": """
        0 low battery |
        2 low battery | !low battery
        3 | ~low battery
        4 battery empty | !low battery
        6 battery empty | !battery empty""",
    "silence while the console was suspended is none": """
        0 stopped | !stopped
        6 contact lost | !stopped?
        7 stopped | !stopped
        20 contact lost | !stopped?
        22 contact lost | !stopped?
        22.5 contact lost | !contact lost, !stopped?""",
    "an error takes the place of the warning of its part": """
        0 diagnostics motor |
        2 diagnostics motor | !diagnostics motor
        4 diagnostics error motor | !diagnostics motor
        6 diagnostics error motor | !diagnostics error motor""",
    "a warning beside an error of its part waits for its own delay": """
        0 diagnostics error motor |
        2 diagnostics error motor | !diagnostics error motor
        2.5 diagnostics motor | !diagnostics error motor
        3 diagnostics error motor | !diagnostics error motor
        3.4 | !diagnostics error motor
        5.1 diagnostics motor | ~diagnostics error motor""",
    "a part that flaps is one alarm until it is well": """
        1 diagnostics motor |
        2 |
        3 diagnostics motor | !diagnostics motor
        4 | !diagnostics motor
        5 diagnostics motor | !diagnostics motor
        8 | ~diagnostics motor""",
}


def states(board: AlarmBoard) -> dict[str, AlarmState]:
    return {alarm.name: alarm.state for alarm in board.all()}


@pytest.mark.parametrize("story", STORIES)
def test_the_board_follows_what_is_found_and_done(story: str) -> None:
    board = AlarmBoard()
    for step in STORIES[story].strip().splitlines():
        moment, _, stands = (part.strip() for part in step.partition("|"))
        seconds, _, found = moment.partition(" ")
        time, before = float(seconds), states(board)
        if found == "ack":
            changed = board.acknowledge(board.all()[0], 100 + time)
        elif found.endswith("shelve"):
            changed = board.shelve(board.all()[0], time, 100 + time)
        else:
            texts = {name: f"{name.upper()}: act" for name in filter(None, found.split(", "))}
            changed = board.update(texts, time, 100 + time)
        said = [
            f"{SIGNS[alarm.state]}{alarm.name}{'?' * alarm.text.endswith('(last known)')}"
            for alarm in board.all()
        ]
        assert ", ".join(said) == stands, step
        now = states(board)
        differ = {name for name in {*before, *now} if before.get(name) != now.get(name)}
        assert {alarm.name for alarm in changed} == differ, step


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
    board = AlarmBoard()
    board.update({STOPPED: "STOPPED AT 12:04: look"}, 0, 100)
    board.update({}, 1, 101)  # It says from when to when.
    assert shown(board).startswith("▲ was: STOPPED AT 12:04, since ")


def test_a_banner_without_room_keeps_what_to_do_and_how_many_more() -> None:
    board = AlarmBoard()
    found = conditions(NORMAL._replace(open_stop=OpenStop(NOW - 12)), NOW)
    for time in (0, 3):
        board.update({**found, BATTERY_EMPTY: "BATTERY EMPTY"}, time, 100)
    assert shown(board).startswith("✗ STOP SENT, no ")
    assert shown(board).endswith(": use the hardware stop   +1 alarm   (a)")


def test_a_stop_that_is_known_to_be_over_is_not_kept_as_last_known() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop"}, 0, 100)
    for time, over, is_over in ((2, (), False), (3, (STOPPED,), True)):
        board.update({CONTACT_LOST: "lost"}, time, 100 + time, over)
        stopped = next(alarm for alarm in board.all() if alarm.name == STOPPED)
        assert stopped.is_over == is_over


@pytest.mark.parametrize("by", [-90_000, 90_000])
def test_a_clock_that_is_set_leaves_an_alarm_shelved_for_its_time(by: int) -> None:
    board = AlarmBoard()
    board.update({STOPPED: "stop: look"}, 0, 100)
    board.shelve(board.all()[0], 0, 100)
    board.update({STOPPED: "stop"}, SHELF_TIME - 60, 100 + by + SHELF_TIME - 60)
    (shelved,) = board.all()
    assert shelved.state == AlarmState.SHELVED
    lines = [text for text, _ in alarm_lines(AlarmRow(shelved, shelved.text), 80, ())]
    assert f"until {time_of_day(100 + by + SHELF_TIME)}" in lines[0]
    board.update({STOPPED: "stop"}, SHELF_TIME, 100 + by + SHELF_TIME)
    assert [alarm.state for alarm in board.all()] == [AlarmState.UNACKNOWLEDGED]


def test_the_text_follows_without_a_new_alarm_until_it_is_gone_for_every_key() -> None:
    board = AlarmBoard()
    board.update({STOPPED: "a"}, 0, 100)
    seen = board.all()[0]
    board.acknowledge(seen, 101)
    assert board.update({STOPPED: "b"}, 6, 106) == []
    (alarm,) = board.all()
    assert (alarm.text, alarm.acknowledged, alarm.since) == ("b", True, 100)
    board.update({}, 7, 107)
    assert board.all() == ()
    assert board.acknowledge(seen, 108) == []
    assert board.shelve(seen, 8, 108) == []
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


def test_the_header_names_what_is_silent_or_moves_on_while_the_rest_is_well() -> None:
    stopped, silent = STATES["motor stopped"], replace(MOTOR, received=NOW - 4)
    for snapshot, word, absent in (
        (stopped, "✗ STOPPED", "MOVING"),
        (stopped._replace(stop_not_obeyed=True), "✗ STILL MOVING", "STOPPED"),
        (NORMAL._replace(motion=silent), "▲ motor_status silent, 4 s", "online"),
        (goal(Phase.LOST, heard=NOW - 3.2), "▲ move_to_shelf silent", "online"),
        (NORMAL, "● online", "silent"),
    ):
        said = header(View(snapshot, NOW, NOW, 0.0, "embedded", "/", History()), 120).plain
        assert word in said
        assert absent not in said


@pytest.mark.parametrize(
    ("done", "moments"),  # s after it was found: whether it holds, and how often it rings
    [
        ("nothing", [(2, True, 0), (3, False, None), (4, True, 1)]),  # before anybody looked
        ("acknowledge", [(2, True, 0), (3, False, None), (4, True, 1)]),
        ("shelve", [(597, True, 0), (600, True, 0), (SHELF_TIME + 1, True, 1), (602, True, 0)]),
    ],
)
def test_a_grave_alarm_rings_again_when_it_comes_again_or_its_shelf_ends(
    done: str, moments: list[tuple[float, bool, int | None]]
) -> None:
    board, bell = AlarmBoard(), AlarmBell()
    board.update({CONTACT_LOST: "lost"}, 0, 100)
    assert len(bell.take_new(board.all())) == 1
    if done == "acknowledge":
        board.acknowledge(board.all()[0], 101)
    elif done == "shelve":
        board.shelve(board.all()[0], 1, 101, "a test")
    for later, holds, rings in moments:
        board.update({CONTACT_LOST: f"lost for {later} s"} if holds else {}, later, 100 + later)
        assert rings is None or len(bell.take_new(board.all())) == rings


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
