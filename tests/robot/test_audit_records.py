"""The form in which consoles say what they did: read whole or not at all, harmless, bounded."""

from __future__ import annotations

import json
from typing import Any

import pytest

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import MAX_LENGTH, AuditRecord, parse, to_json
from archo_tui.robot.state.events import Event, EventLog

pytestmark = pytest.mark.pure

SET = AuditRecord(
    "set", {"node": "/motor", "values": {"speed": 0.5, "names": ["a", "b"]}}, Code.DONE
)
FORM = {"console": "anna", "verb": "stop", "arguments": {}, "code": "done", "text": "STOP"}


def test_what_one_console_writes_another_reads() -> None:
    told = parse(to_json("anna", SET, "set motor speed 0.5: speed is 0.5, was 1.0"))
    assert told == ("anna", SET, "set motor speed 0.5: speed is 0.5, was 1.0")


def test_what_a_later_console_adds_is_left_alone() -> None:
    told = parse(json.dumps({**FORM, "since": [1]}))
    assert told == ("anna", AuditRecord("stop", {}, Code.DONE), "STOP")


@pytest.mark.parametrize(
    "form",
    [
        *("", "STOP", "null", "7", "[]", '"console"', "{}", '{"console": "anna"}'),
        *("[" * MAX_LENGTH, "1" * MAX_LENGTH, '{"a":' * 3000),
        *(json.dumps({**FORM, name: 7}) for name in FORM),
        *(json.dumps({**FORM, name: None}) for name in FORM),
        json.dumps({**FORM, "arguments": []}),
        json.dumps({**FORM, "code": "perhaps"}),
        json.dumps({**FORM, "code": ["done"]}),
        json.dumps({**FORM, "text": "x" * MAX_LENGTH}),
    ],
    ids=str.__len__,
)
def test_anything_else_is_not_read(form: str) -> None:
    assert parse(form) is None


def test_what_it_holds_can_be_kept_and_shown_whatever_it_is() -> None:
    deep: Any = []
    for _ in range(500):
        deep = [deep]
    hostile = {
        "\x1b[2J": "\x1b]0;\u202e",
        "deep": deep,
        "many": [0] * 1000,
        "long": "x" * 5000,
        "numbers": [float("nan"), float("inf"), 10**3000, -1, 0.5, True, None],
    }
    told = parse(json.dumps({**FORM, "verb": "\x9b", "arguments": hostile}))
    assert told is not None
    event = EventLog().add(Event(0.0, "PEER", told.console, told.text, audit_record=told.record))
    assert event.audit_record is not None
    kept = json.dumps(event.audit_record, allow_nan=False, ensure_ascii=False)
    assert kept.isascii() or "\ufffd" in kept
    assert not set(kept) & set("\x1b\x9b\u202e")
    assert len(kept) < 3000
    assert event.audit_record.arguments["numbers"][3:] == [-1, 0.5, True, None]


def test_of_more_values_than_are_read_the_names_are_told() -> None:
    values = {f"parameter_{number}": "x" * 400 for number in range(100)}
    form = to_json(
        "anna", AuditRecord("set", {"node": "/motor", "values": values}, Code.DONE), "set"
    )
    told = parse(form)
    assert told is not None
    assert told.record.arguments["node"] == "/motor"
    assert told.record.arguments["values"] == dict.fromkeys(values)


def test_a_record_with_more_than_is_read_says_at_least_what_was_done() -> None:
    many = ["x" * 400] * 100
    for arguments, kept in (
        ({"names": many, "speed": 1.0}, {"names": None, "speed": 1.0}),
        ({f"name_{number}": "x" * 400 for number in range(100)}, {}),
    ):
        told = parse(to_json("anna", AuditRecord("go", arguments, Code.ACCEPTED), "go"))
        assert told is not None
        assert told.record == AuditRecord("go", kept, Code.ACCEPTED)
