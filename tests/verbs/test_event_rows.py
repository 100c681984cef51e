"""The rows of events: what has happened is said once, and nothing is lost."""

from __future__ import annotations

import pytest

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.state.events import Event, EventLog
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.text.event_rows import event_rows, without_repeats

STOP = "ros2 service call /emergency_stop archo_interfaces/srv/EmergencyStop '{}'"


def did(
    time: float, verb: str, text: str, code: Code = Code.DONE, level: str = "YOU", command: str = ""
) -> Event:
    source = "console" if level in ("YOU", "GOAL") else f"{level.lower()} 4711"
    record = AuditRecord(verb, {}, code)
    return Event(time, level, source, text, command, audit_record=record)


def logged(time: float, text: str, level: str = "WARN", source: str = "motor_controller") -> Event:
    return Event(time, level, source, text)


def rows_of(*events: Event, hosted: tuple[Hosted, ...] = ()) -> list[tuple[float, str]]:
    log = EventLog()
    for event in events:
        log.add(event)
    rows = event_rows(log.all(), hosted)
    assert sorted(e.number for row in rows for e in row.events) == sorted(
        e.number for e in log.all()
    )
    return [(row.time, row.text) for row in rows]


def texts_of(*events: Event, hosted: tuple[Hosted, ...] = ()) -> list[str]:
    return [text for _, text in rows_of(*events, hosted=hosted)]


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("reset encoder: Encoder reset to zero", "reset encoder: zero"),
        ("charge: Charging", "charge"),
        ("discharge: Not charging", "discharge: Not charging"),
        ("lamp: The lamp is on", "lamp: on"),
        ("set motor max_speed 0.4: max_speed is 0.4, was 0.8", "set motor max_speed 0.4: was 0.8"),
        ("set motor max_speed 9: max_speed is 2, was 0.8", "set motor max_speed 9: 2, was 0.8"),
        ("level of a ERROR: ERROR and above", "level of a ERROR: ERROR and above"),
        ("shelf 3 aborted: 3 retries failed", "shelf 3 aborted: 3 retries failed"),
        ("set motor gain 5: gain is .5", "set motor gain 5: .5"),
        ("charge: Charging refused", "charge: refused"),
        ("charge: Charge: not possible", "charge: not possible"),
        ("reset encoder: Encoder not reset", "reset encoder: not reset"),
        ("charge: 充电失败", "charge: 充电失败"),
        ("charge: ", "charge"),
        ("STOP: confirmed", "STOP: confirmed"),
        ("Arrived at shelf 12", "Arrived at shelf 12"),
    ],
)
def test_an_answer_is_shown_without_the_words_of_its_request(text: str, short: str) -> None:
    assert without_repeats(text) == short


def test_what_failed_is_said_in_its_own_words() -> None:
    refused = did(0, "charge", "charge: charging is not possible", Code.REFUSED)
    assert texts_of(refused) == [refused.text]


def test_a_stop_and_its_release_are_one_row_at_the_release() -> None:
    released = "release stop: Released; nothing resumes by itself"
    stop = did(10, "stop", "STOP: confirmed")
    ((time, text), other) = rows_of(
        stop, logged(12, "wheel slips"), did(20, "release", released), did(30, "reset", "reset: ok")
    )[1:]
    assert time == 20
    assert text.startswith("STOP: confirmed ")
    assert text.endswith(", released: nothing resumes by itself")
    assert other == (30, "reset: ok")


def test_a_release_from_a_shell_is_named() -> None:
    (text,) = texts_of(
        did(10, "stop", "STOP: confirmed"), did(20, "release", "release stop: ok", level="SHELL")
    )
    assert text.endswith(", released by shell 4711: ok")


@pytest.mark.parametrize(
    "events",
    [
        [did(10, "stop", "STOP: not confirmed", Code.NOT_CONFIRMED)],
        [did(10, "stop", "STOP: confirmed", level="PEER")],
        [did(10, "stop", "STOP: confirmed"), did(12, "release", "released", level="PEER")],
        [],
    ],
)
def test_a_release_of_no_confirmed_stop_from_here_is_a_row(events: list[Event]) -> None:
    released = did(20, "release", "release stop: Released by hand")
    assert len(texts_of(*events, released)) == len(events) + 1


def test_a_release_that_failed_or_came_late_is_a_row() -> None:
    stop = did(10, "stop", "STOP: confirmed")
    for text, code in (
        ("release stop: the door is open", Code.REFUSED),
        ("release stop, answered late: Released", Code.DONE),
    ):
        assert texts_of(stop, did(20, "release", text, code)) == ["STOP: confirmed", text]


def test_a_warning_that_only_repeats_an_outcome_is_part_of_its_row() -> None:
    command = "ros2 action send_goal /move_to_shelf archo_interfaces/action/MoveToShelf '{}'"
    assert texts_of(
        logged(10, "Emergency stop"),
        did(10.2, "stop", "STOP: confirmed", command=STOP),
        logged(20, "Goal refused: emergency stop: release it first"),
        did(20.1, "go", "go to 5: emergency stop: release it first", Code.REFUSED, command=command),
    ) == ["STOP: confirmed", "go to 5: emergency stop: release it first"]


@pytest.mark.parametrize(
    "log",
    [
        logged(10, "Emergency stop, brake is hot"),  # more than the STOP says
        logged(14, "Emergency stop"),  # at another time
        logged(10, "Emergency stop", level="ERROR"),
        logged(10, "!"),
    ],
)
def test_a_warning_that_says_more_is_a_row(log: Event) -> None:
    assert len(texts_of(log, did(10.2, "stop", "STOP: confirmed", command=STOP))) == 2


def test_a_recorded_stop_its_warning_and_its_release_are_one_row() -> None:
    released = "release stop: Released; nothing resumes by itself"
    (text,) = texts_of(
        logged(10, "Emergency stop"),
        Event(10.2, "YOU", "console", "STOP: confirmed", STOP, code="done"),
        Event(20, "YOU", "console", released, code="done"),
    )
    assert text.endswith(", released: nothing resumes by itself")


def test_a_warning_of_what_was_set_is_a_row_since_it_is_news() -> None:
    threshold = "battery_monitor low_battery_threshold 90"
    command = f"ros2 param set /{threshold}"
    for text, code in (("was 20", Code.DONE), ("not in range", Code.REFUSED)):
        act = did(10.2, "set", f"set {threshold}: {text}", code, command=command)
        assert len(texts_of(act, logged(10.4, "Low battery", source="battery_monitor"))) == 2


def test_a_warning_of_a_number_with_another_sign_is_a_row() -> None:
    refused = did(10.2, "tilt", "tilt to 5: angle 5 refused", Code.REFUSED)
    assert len(texts_of(refused, logged(10, "angle 5 refused"))) == 1
    assert len(texts_of(refused, logged(10, "angle -5 refused"))) == 2


def test_a_warning_that_came_more_often_than_it_was_done_is_a_row() -> None:
    stops = [did(time, "stop", "STOP: confirmed", command=STOP) for time in (10, 30)]
    logs = [logged(time, "Emergency stop") for time in (10, 20, 30)]
    assert len(texts_of(stops[0], logs[0], stops[1], logs[2])) == 2
    assert len(texts_of(stops[0], *logs, stops[1])) == 3


def test_what_a_node_of_the_users_own_file_logs_is_a_row() -> None:
    own = (Hosted("/motor_controller", file="motor.py"),)
    stop = did(10, "stop", "STOP: confirmed", command=STOP)
    assert len(texts_of(logged(10, "Emergency stop"), stop, hosted=own)) == 2
