"""What is written in YAML means what its core schema says, and nothing hangs or ends."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from archo_tui.base.regular_files import MAX_BYTES
from archo_tui.base.yaml_text.bounded_yaml import load, scalar_texts
from archo_tui.base.yaml_text.core_schema import YamlFault
from archo_tui.base.yaml_text.dump import block, flow


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("010", 10),
        ("-08", -8),
        ("+1", 1),
        ("0x1F", 31),
        ("0o17", 15),
        ("0b11", "0b11"),
        ("1_0", "1_0"),
        ("1:30", "1:30"),
        ("1e3", 1000.0),
        ("1E-3", 0.001),
        (".5", 0.5),
        ("5.", 5.0),
        ("-.inf", -math.inf),
        ("+.Inf", math.inf),
        ("inf", "inf"),
        ("true", True),
        ("FALSE", False),
        ("yes", "yes"),
        ("off", "off"),
        ("~", None),
        ("Null", None),
        ("", None),
        ("2001-01-01", "2001-01-01"),
        ("0o8", "0o8"),
        ("٣", "٣"),
        ("'12'", "12"),
        ("!!str 12", "12"),
        ("!!float 1", 1.0),
        ("on: {on: 1, 1: on}", {"on": {"on": 1, "1": "on"}}),
        ("<<: {a: 1}", {"<<": {"a": 1}}),
        ("=", "="),
        ("[a, [], {}, '']", ["a", [], {}, ""]),
        ("&a b", "b"),
    ],
)
def test_a_text_means_what_the_core_schema_says(text: str, value: Any) -> None:
    got = load(text)
    assert got == value
    assert type(got) is type(value)


@pytest.mark.parametrize("text", [".nan", ".NaN", ".NAN"])
def test_nan_is_written_with_a_dot(text: str) -> None:
    assert math.isnan(load(text))


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("a: 1\nb: 2\na: 3", 3, "a is given twice"),
        ("x:\n  a: 1\n  'a': 3", 3, "a is given twice"),
        ("a: &a [*a]", 1, "aliases (*a) are not read: write it out"),
        ("a: &a [1]\nb: [*a, *a]", 2, "aliases (*a) are not read: write it out"),
        ("[" * 9000, 1, "nested more than 20 deep"),
        ("{a: " * 9000, 1, "nested more than 20 deep"),
        ("- " * 9000, 1, "nested more than 20 deep"),
        ("a: [1,\n  2", 2, "not YAML: expected ',' or ']', but got '<stream end>'"),
        ("a: 1\nb: c: d", 2, "not YAML: mapping values are not allowed here"),
        ("--- 1\n--- 2", 2, "not YAML: but found another document"),
        ("a\0", 1, "not YAML: unacceptable character #x0000: special characters are not allowed"),
        ("\ud800", 1, "not YAML: unacceptable character #xd800: special characters are not all"),
        ('"\\U00110000"', 1, "not YAML: chr() arg not in range(0x110000)"),
        ("a:\n  !!int x", 2, "not of the kind !!int: x"),
        ("!!bool yes", 1, "not of the kind !!bool: yes"),
        ("!!timestamp 2001-99-99", 1, "!!timestamp is not read here"),
        ("!!binary AQ==", 1, "!!binary is not read here"),
        ("!!set {a}", 1, "!!set is not read here"),
        ("!me x", 1, "!me is not read here"),
        ("? [a]\n: 1", 1, "expected a name"),
        ("9" * 5000, 1, "a number of 5000 digits"),
        ("1e999", 1, "too large for a number: 1e999"),
        ('!!int "a\nb"', 1, "not of the kind !!int: a b"),
        ('!!int "a\\nb"', 1, "not of the kind !!int: 'a\\nb'"),
        ('{"a\\u2028": 1, "a\\u2028": 2}', 1, "'a\\u2028' is given twice"),
        ("a" * (MAX_BYTES + 1), 1, f"more than {MAX_BYTES} characters"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_line(text: str, line: int, said: str) -> None:
    with pytest.raises(YamlFault) as caught:
        load(text)
    assert caught.value.line == line
    assert str(caught.value).startswith(f"line {line}: {said}")
    assert len(str(caught.value).splitlines()) == 1


def test_the_elements_of_a_list_are_read_as_they_were_typed() -> None:
    assert scalar_texts("[010, 1_0, yes, ~, 'a b', '']") == ["010", "1_0", "yes", "~", "a b", ""]


@pytest.mark.parametrize("text", ["", "1", "{a: 1}", "[[1]]", "[{a: 1}]", "&a [*a]", "[" * 9000])
def test_what_is_no_list_of_single_values_is_refused(text: str) -> None:
    with pytest.raises(YamlFault):
        scalar_texts(text)


def test_whatever_is_typed_is_a_value_or_one_line() -> None:
    chance = random.Random(24)
    parts = [
        "&a",
        "*a",
        "!!int ",
        "!x ",
        "<<",
        "? ",
        "|",
        "\\U0011ffff",
        "\0",
        "\ud800",
        "%YAML 9\n",
    ]
    parts += ["---", "0x", "1e", "!!map {", "!!str [", "\u2028", "\t", *"[]{}:,-'\"#~>ab12. \n"]
    for _ in range(3000):
        text = "".join(chance.choices(parts, k=chance.randint(1, 25)))
        try:
            value = load(text)
        except YamlFault as fault:
            said = str(fault)
            assert len(said.splitlines()) == 1
        else:
            assert repr(load(flow(value))) == repr(load(block(value))) == repr(value)
