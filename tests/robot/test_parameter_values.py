"""What a typed text means for a parameter, and what is said when it means nothing."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from archo_tui.robot.graph.parameter_values import parse, range_text
from archo_tui.robot.messages.typed import typed_text
from archo_tui.robot.messages.values import text_of
from archo_tui.robot.state.graph import Parameter
from tests.support.values import value_of

pytestmark = pytest.mark.pure


def parameter(kind: str, **options: Any) -> Parameter:
    return Parameter("/node", "name", kind, None, None, **options)


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        ("double", "1", 1.0),
        ("double", " 2.5e-1 ", 0.25),
        ("double", ".5", 0.5),
        ("double", "5.", 5.0),
        ("double", "1e3", 1000.0),
        ("double", "+1.5e-3", 0.0015),
        ("integer", "-7", -7),
        ("integer", " +7 ", 7),
        ("integer", f"{'0' * 40}7", 7),
        ("bool", "Yes", True),
        ("bool", "off", False),
        ("string", "yes", "yes"),
        ("string", "", ""),
        ("string", " spaced ", " spaced "),
        ("double", "-.inf", -math.inf),
        ("double[]", "[.inf, 1]", [math.inf, 1.0]),
        ("double[]", "[1, 2.5]", [1.0, 2.5]),
        ("integer[]", "[]", []),
        ("bool[]", "[true, no]", [True, False]),
        ("string[]", "[a, 'b c', 1]", ["a", "b c", "1"]),
    ],
)
def test_the_declared_type_decides(kind: str, text: str, value: object) -> None:
    got = parse(parameter(kind), text)
    assert got == value
    assert type(got) is type(value)


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("double", "", "a value is needed (double)"),
        ("double", "fast", "not a number: fast"),
        ("double", "NaN", "not a finite number: NaN"),
        ("double", "-inf", "not a finite number: -inf"),
        ("double", "1_0.5", "not a number: 1_0.5"),
        ("double", "１.５", "not a number: １.５"),
        ("double", "infinity", "not a finite number: infinity"),
        ("double", "inf", "not a finite number: inf"),
        ("double", ".", "not a number: ."),
        ("integer", "1.0", "not a whole number: 1.0"),
        ("integer", "1_2", "not a whole number: 1_2"),
        ("integer", "０５", "not a whole number: ０５"),
        ("integer", "٣", "not a whole number: ٣"),
        ("integer", "9" * 5000, f"too large for an integer: {'9' * 5000}"),
        ("integer", "9223372036854775808", "too large for an integer: 9223372036854775808"),
        ("bool", "2", "not true or false: 2"),
        ("integer[]", "1, 2", "not a list like [1, 2]: 1, 2"),
        ("integer[]", "[1, x]", "not a whole number: x"),
        ("integer[]", "[1, 1_2]", "not a whole number: 1_2"),
        ("integer[]", "[1:30]", "not a whole number: 1:30"),
        ("double[]", "[1_0.5]", "not a number: 1_0.5"),
        ("string", "bell\x07", "control characters are not allowed"),
        ("string", "x" * 10_001, "too long: 10001 characters, at most 10000"),
        ("byte[]", "[1]", "a parameter of type byte[] cannot be edited here"),
    ],
)
def test_what_means_nothing_is_said_in_one_line(kind: str, text: str, said: str) -> None:
    with pytest.raises(ValueError) as caught:
        parse(parameter(kind), text)
    assert str(caught.value) == said


@pytest.mark.parametrize("kind", ["bool", "integer", "double", "string"])
def test_the_text_of_a_value_is_read_as_that_value(kind: str) -> None:
    chance = random.Random(kind)
    of = {"bool": "boolean", "integer": "int64"}.get(kind, kind)
    for _ in range(200):
        value = value_of(of, chance)
        if kind == "double" and not math.isfinite(value):
            continue  # which cannot be typed
        if value != "" and str(value).isprintable():
            assert parse(parameter(kind), typed_text(value)) == value
        assert parse(parameter(f"{kind}[]"), typed_text([value, value])) == [value, value]


def test_ranges_and_read_only() -> None:
    limited = parameter("double", low=0.05, high=2.0)
    assert range_text(limited) == "0.05 .. 2"
    exact = limited._replace(low=0.1234567, high=1234567)
    assert range_text(exact) == "0.1234567 .. 1234567"
    assert parse(limited, "2") == 2.0
    with pytest.raises(ValueError, match=r"allowed 0.05 .. 2, not 2.01"):
        parse(limited, "2.01")
    with pytest.raises(ValueError, match="read-only"):
        parse(parameter("integer", read_only=True), "1")


def test_values_read_as_they_are_written() -> None:
    assert [text_of(v) for v in (True, 1, 0.5, "x", [1.0, False])] == [
        "true", "1", "0.5", "x", "[1.0, false]"
    ]  # fmt: skip
