"""The log of events, and the form in which consoles say what they did: bounded and harmless."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import pytest
from rich.cells import cell_len

from archo_tui.base.safe_text import harmless, safe, safe_in_place
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.audit_records import MAX_LENGTH, AuditRecord, parse, to_json
from archo_tui.robot.state.events import LEFT_OUT, Event, EventLog

pytestmark = pytest.mark.pure


def event(text: str, level: str = "WARN", source: str = "dashboard", time: float = 1.0) -> Event:
    return Event(time, level, source, text)


def test_lines_that_differ_in_their_readings_are_one_with_a_count() -> None:
    log = EventLog()
    for percentage in (19.9, 19.8, 19.7):
        log.add(event(f"Dashboard sees: {percentage}%", "INFO"))
        log.add(event(f"Low battery: {percentage}%"))
    for offset in (0.1, -0.1):
        log.add(event(f"Off the line by {offset}."))
    assert [(e.text, e.count) for e in log.all()] == [
        ("Dashboard sees: 19.7%", 3),
        ("Low battery: 19.7%", 3),
        ("Off the line by -0.1.", 2),
    ]


@pytest.mark.parametrize(
    ("level", "texts"),
    [
        ("ERROR", ("Joint 1 overheated", "Joint 2 overheated", "Joint 10 overheated")),
        ("INFO", ("Moving to shelf 3", "Moving to shelf 5", "Moving to shelf 7")),
        ("WARN", ("No answer from 10.0.0.1", "No answer from 10.0.0.2")),
    ],
)
def test_lines_about_different_things_are_lines_of_their_own(
    level: str, texts: Sequence[str]
) -> None:
    log = EventLog()
    for text in (*texts, *texts):
        log.add(event(text, level))
    assert [(e.text, e.count) for e in log.all()] == [(text, 2) for text in texts]


def test_of_a_flood_50_lines_a_second_are_kept_and_the_rest_counted() -> None:
    log = EventLog()
    for number in range(100):
        log.add(event(f"Tick {number}", "INFO"))
        log.add(event("Alike", "INFO"))
        log.add(event(f"Joint {number} hot"))  # a warning is never left out
    texts = [e.text for e in log.all() if e.level == "INFO"]
    assert len(texts) == 51
    assert "Tick 48" in texts
    assert "Tick 49" not in texts
    left = [e for e in log.all() if "left out" in e.text]
    assert [(e.text, e.count) for e in left] == [(LEFT_OUT, 51)]
    assert sum(e.text.startswith("Joint") for e in log.all()) == 100
    log.add(event("Another source", "INFO", source="talker"))
    log.add(event("Tick 100", "INFO", time=2.1))
    assert [e.text for e in log.all()][-2:] == ["Another source", "Tick 100"]


def test_a_flood_pushes_out_neither_an_error_nor_what_the_operator_did() -> None:
    log = EventLog()
    log.add(event("reset", "YOU"))
    for number in range(3000):
        log.add(event(chr(0x4E00 + number)))
    log.add(event("Joint 1 overheated", "ERROR"))
    for number in range(3000):
        log.add(event(f"Hello World: {number}", "INFO", time=0.1 * number))
    assert 500 < len(log.all()) <= 1000
    assert log.all()[0].text == "reset"
    assert [e.text for e in log.all() if e.level == "ERROR"] == ["Joint 1 overheated"]
    assert log.all()[-1].text == "Hello World: 2999"
    for _ in range(1000):
        log.add(event("again", "YOU"))
    assert len(log.all()) == 1000
    assert sum(e.level == "YOU" for e in log.all()) < 500


def test_a_repeat_is_the_newest_with_its_first_and_last_time() -> None:
    log = EventLog()
    log.add(event("low 19.0", time=1.0))
    log.add(event("other", time=2.0))
    log.add(event("low 18.5", time=3.0))
    assert [(e.text, e.count, e.first, e.time) for e in log.all()] == [
        ("other", 1, 2.0, 2.0),
        ("low 18.5", 2, 1.0, 3.0),
    ]
    assert log.all()[1].number == 1  # still the same one


def test_what_a_terminal_could_act_on_is_taken_out() -> None:
    assert harmless("\x1b[2Jhidden\x07 \u202eright to left") == "�[2Jhidden� �right to left"
    assert harmless("ünï ✓ 漢") == "ünï ✓ 漢"
    assert len(harmless("x" * 1_000_000)) < 600


def test_a_line_feed_stays_in_a_log_line_and_is_a_blank_elsewhere() -> None:
    log = EventLog()
    log.add(event("Incoming request\na: 2 b: 3\n"))
    assert log.all()[0].text == "Incoming request\na: 2 b: 3"
    assert harmless("Incoming request\r\na: 2 b: 3") == "Incoming request a: 2 b: 3"


@pytest.mark.parametrize("char", "\x1b\x07\x9b\u202e\u2028\u2029\u061c\u200b\U000e0041\ud800\ufeff")
def test_each_of_these_is_shown_as_a_mark_or_in_its_cells(char: str) -> None:
    assert safe(f"a{char}b") == "a\N{REPLACEMENT CHARACTER}b"
    laid_out = safe_in_place(f"a{char}b")
    assert char not in laid_out
    assert cell_len(laid_out) == cell_len(f"a{char}b")


@pytest.mark.parametrize(
    ("text", "is_letter"),
    [
        ("\u0645\u06cc\u200c\u0631\u0648\u0645", True),
        ("\u0915\u094d\u200d\u0937", True),
        ("\U0001f469\u200d\U0001f4bb", True),
        ("\u2764\ufe0f\u200d\U0001f525", True),
        ("ad\u200dmin", False),
        ("ad\u200cmin", False),
        ("\u0645\u200c\u200c\u0631", False),
        ("\u200c\u0645", False),
        ("\u0645\u200c", False),
    ],
)
def test_a_joiner_is_a_letter_inside_a_word_and_else_shown_as_a_mark(
    text: str, is_letter: bool
) -> None:
    shown = safe(text)
    if is_letter:
        assert shown == safe_in_place(text) == harmless(f"{text}.")[:-1] == text
    else:
        assert not {"\u200c", "\u200d"} & {*shown}
        assert "\N{REPLACEMENT CHARACTER}" in shown


def test_of_many_marks_on_one_letter_four_stay() -> None:
    assert safe("e" + "\u0301" * 40 + "x") == "e" + "\u0301" * 4 + "x"


# What a console says that it did is read whole or not at all.

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


@pytest.mark.parametrize(
    ("arguments", "kept"),
    [
        (
            {"node": "/motor", "values": {f"parameter_{n}": "x" * 400 for n in range(100)}},
            {"node": "/motor", "values": {f"parameter_{n}": None for n in range(100)}},
        ),
        ({"names": ["x" * 400] * 100, "speed": 1.0}, {"names": None, "speed": 1.0}),
        ({f"name_{n}": "x" * 400 for n in range(100)}, {}),
    ],
)
def test_a_record_with_more_than_is_read_says_at_least_what_was_done(
    arguments: dict[str, Any], kept: dict[str, Any]
) -> None:
    told = parse(to_json("anna", AuditRecord("go", arguments, Code.ACCEPTED), "go"))
    assert told is not None
    assert told.record == AuditRecord("go", kept, Code.ACCEPTED)
