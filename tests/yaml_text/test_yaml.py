"""What is read in YAML means what its core schema says, and what is written means the same."""

from __future__ import annotations

import array
import math
import random
import shlex
from typing import Any

import pytest
import yaml
from rclpy.parameter import get_parameter_value

from archo_tui.base.regular_files import MAX_BYTES
from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.base.yaml_text.bounded_yaml import load, scalar_texts
from archo_tui.base.yaml_text.core_schema import YamlFault
from archo_tui.base.yaml_text.dump import block, flow
from archo_tui.robot.graph.parameter_values import as_python
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.text import flat_fields
from archo_tui.robot.messages.typed import default_text, parse_field
from archo_tui.robot.messages.values import checked, filled
from archo_tui.robot_file.model import FormField
from archo_tui.screen.message_form import default_yaml
from tests.support.night import corners
from tests.support.values import installed, told, value_of, values_of


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("010", 10),
        ("0x1F", 31),
        ("0o17", 15),
        ("1_0", "1_0"),
        ("1:30", "1:30"),
        ("1e3", 1000.0),
        (".5", 0.5),
        ("-.inf", -math.inf),
        ("+.Inf", math.inf),
        ("inf", "inf"),
        ("true", True),
        ("yes", "yes"),
        ("off", "off"),
        ("~", None),
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
        ("{a: " * 9000, 1, "nested more than 20 deep"),
        ("a: [1,\n  2", 2, "not YAML: expected ',' or ']', but got '<stream end>'"),
        ("a: 1\nb: c: d", 2, "not YAML: mapping values are not allowed here"),
        ("--- 1\n--- 2", 2, "not YAML: but found another document"),
        ("a\0", 1, "not YAML: unacceptable character #x0000: special characters are not allowed"),
        ("\ud800", 1, "not YAML: unacceptable character #xd800: special characters are not all"),
        ('"\\U00110000"', 1, "not YAML: chr() arg not in range(0x110000)"),
        ("a:\n  !!int x", 2, "not of the kind !!int: x"),
        ("!!bool yes", 1, "not of the kind !!bool: yes"),
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
    parts = [*("&a", "*a", "!!int ", "!x ", "<<", "? ", "|", "\\U0011ffff", "\0", "\ud800")]
    parts += ["%YAML 9\n"]
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


TYPES = installed()
PACKAGES = sorted({name.partition("/")[0] for name in TYPES})


def types_of(package: str) -> list[str]:
    """The names of its messages, and of the parts of its services and actions."""
    return [name for name in TYPES if name.startswith(f"{package}/")]


@pytest.mark.parametrize("package", PACKAGES)
def test_a_prefilled_form_that_is_sent_untouched_is_the_types_defaults(package: str) -> None:
    for name in types_of(package):
        sends_untouched(name, TYPES[name]())


def sends_untouched(name: str, made: Any) -> None:
    """A form, and a text, that are filled with that message send it."""
    fields = list(flat_fields(made))
    given = FormField()
    typed = {field.path: parse_field(field, given, default_text(field, given)) for field in fields}
    assert told(filled(TYPES[name](), typed)) == told(made), name
    assert told(filled(TYPES[name](), bounded_yaml.load(default_yaml(fields)))) == told(made), name


@pytest.mark.parametrize("package", corners(PACKAGES[::4], PACKAGES))
def test_a_form_of_any_values_that_is_sent_untouched_is_those(package: str) -> None:
    chance = random.Random(package)
    for name in 3 * types_of(package):
        sends_untouched(name, filled(TYPES[name](), values_of(TYPES[name], chance)))


def set_as_ros2_does(message: Any, values: dict[str, Any]) -> None:
    """What `ros2 service call` and its like do with what they were given.

    By the type of the value that the field has: bytes of a number are so many zeros.
    """
    kinds = message.get_fields_and_field_types()
    for name, given in values.items():
        has = getattr(message, name)
        if hasattr(has, "dtype"):
            value: Any = checked(kinds[name], given, name)
        elif isinstance(has, array.array):
            value = array.array(has.typecode, given)
        elif hasattr(has, "get_fields_and_field_types"):
            value = type(has)()
            set_as_ros2_does(value, given)
        else:
            value = given if type(given) is type(has) else type(has)(given)
        if isinstance(value, list) and value and isinstance(value[0], dict):
            value = checked(kinds[name], [{}] * len(value), name)  # as many, with their defaults
            for made, item in zip(value, given, strict=True):
                set_as_ros2_does(made, item)
        setattr(message, name, value)


@pytest.mark.parametrize("package", PACKAGES)
def test_the_copied_command_sends_the_same_message(package: str) -> None:
    chance = random.Random(package)
    for name in types_of(package):
        sent = filled(TYPES[name](), values_of(TYPES[name], chance))
        for command in (
            ros2_command.service_call("/it", "its/srv/Type", sent),
            ros2_command.send_goal("/it", "its/action/Type", sent),
        ):
            assert "\n" not in command, name
            received = TYPES[name]()
            set_as_ros2_does(received, yaml.safe_load(shlex.split(command)[5]))
            assert told(received) == told(sent), name


@pytest.mark.parametrize(
    "kind",
    ["boolean", "int64", "double", "string"]
    + [f"sequence<{kind}>" for kind in ("boolean", "int64", "double", "string")],
)
def test_the_copied_command_sets_the_parameter_to_the_same_value(kind: str) -> None:
    chance = random.Random(kind)
    for _ in range(100):
        value = value_of(kind, chance)
        command = ros2_command.set_parameters("/node", {"name": value})
        if value == []:  # of booleans, `ros2` would say
            assert command == ""
            continue
        words = shlex.split(command)
        assert words[:5] == ["ros2", "param", "set", "/node", "name"]
        assert words[5][0] != "-"  # which would be an option
        got = as_python(get_parameter_value(words[5]))
        assert type(got) is type(value)
        assert told(got) == told(value)


def test_what_is_plainly_a_word_is_not_quoted() -> None:
    assert flow({"frame": "map", "y": 1, "on": "on"}) == '{frame: map, y: 1, "on": "on"}'


def test_emoji_are_written_as_they_are_with_or_without_quotes() -> None:
    for text in ("battery \U0001f50b low", "a\nb \U0001f50b", "\\U0001F50B", "\\\\\U0001f50b"):
        written = flow([text])
        assert yaml.safe_load(written) == [text]
        assert ("\U0001f50b" in written) == ("\U0001f50b" in text)
