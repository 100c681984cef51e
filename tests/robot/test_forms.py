"""What a typed text means for a field of a message, and what is said when it means nothing."""

from __future__ import annotations

import math
from typing import Any

import pytest

from archo_tui.robot.messages.typed import default_text, parse_field, range_text
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot_file.model import FormField, ParameterRef

pytestmark = pytest.mark.pure


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        ("int32", " +12 ", 12),
        ("int32", f"{'0' * 40}12", 12),
        ("double", ".5", 0.5),
        ("double", "-5.", -5.0),
        ("float", "1e3", 1000.0),
        ("sequence<int32>", "[1, -2]", [1, -2]),
        ("sequence<double, 5>", "[1, .5]", [1.0, 0.5]),
        ("double[2]", "[1e3, +2]", [1000.0, 2.0]),
        ("sequence<string>", "[a, 'b c']", ["a", "b c"]),
        ("sequence<string>", "[010, yes]", ["010", "yes"]),
        ("sequence<string<3>, 3>", "[abc]", ["abc"]),
        ("int32", "010", 10),
        ("sequence<int32>", "[010]", [10]),
        ("boolean", "on", True),
        ("sequence<boolean>", "[on, false]", [True, False]),
        ("sequence<float>", "[1e3]", [1000.0]),
        ("double", "inf", math.inf),
        ("double", "-.inf", -math.inf),
        ("sequence<double>", "[inf, -.Inf]", [math.inf, -math.inf]),
        ("sequence<octet>", "[0, 255]", [0, 255]),
    ],
)
def test_the_type_of_the_field_decides(kind: str, text: str, value: Any) -> None:
    assert parse_field(TypedField("x", kind, None), FormField(), text) == value


@pytest.mark.parametrize("text", ["1_2", "０５", "٣", "1_0.5", "infinity", "0x10", "1 2", "--1"])
@pytest.mark.parametrize(
    ("kind", "what"),
    [("int32", "a whole number"), ("double", "a number"), ("sequence<double>", "a list")],
)
def test_what_only_python_or_yaml_takes_is_no_number(kind: str, what: str, text: str) -> None:
    typed = f"[{text}]" if what == "a list" else text
    with pytest.raises(ValueError) as caught:
        parse_field(TypedField("x", kind, None), FormField(label="Way"), typed)
    assert str(caught.value) == f"Way: not {what}: {typed}"


@pytest.mark.parametrize("text", ["nan", ".nan", ".NaN"])
def test_nan_is_the_same_in_a_field_and_in_a_list(text: str) -> None:
    assert math.isnan(parse_field(TypedField("x", "float", None), FormField(), text))
    assert math.isnan(
        parse_field(TypedField("x", "sequence<float>", None), FormField(), f"[{text}]")[0]
    )


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("int32", "3000000000", "x: at most 2147483647, not 3000000000"),
        ("octet", "256", "x: at most 255, not 256"),
        ("float", "1e39", "x: 1.0e+39 is not within -3.402823466e+38 .. 3.402823466e+38"),
        ("uint8[4]", "[1]", "x: [1] has 1 elements, not 4"),
        ("sequence<int8>", "[1, 300]", "x[1]: 300 is not within -128 .. 127"),
        ("sequence<int64>", "[true]", "x: not a list: [true]"),
        ("sequence<int64>", "[1:30]", "x: not a list: [1:30]"),
        ("sequence<string>", "[[a]]", "x: not a list of single values: [[a]]"),
        ("sequence<int8>", "&a [*a]", "x: aliases (*a) are not read: write it out: &a [*a]"),
        ("sequence<int8>", "[" * 9000, f"x: nested more than 20 deep: {'[' * 20} ..."),
        ("sequence<a_msgs/A>", "[" * 9000, f"x: nested more than 20 deep: {'[' * 20} ..."),
        ("string<8>", "abcdefghijkl", "x: abcdefghijkl has 12 characters, at most 8"),
        ("string", "a" * 10_001, "x: 10001 characters, at most 10000"),
        ("sequence<string>", f"[{'a' * 10_000}]", "x: 10002 characters, at most 10000"),
        ("string", "a\0", 'x: "a\\0" contains a null character'),
        ("builtin_interfaces/Time[1]", "[{sec: 1, sec: 2}]", "x: sec is given twice: "),
        ("builtin_interfaces/Time[1]", "[{sec: 1.5}]", "x[0].sec: 1.5 is not a whole number"),
    ],
)
def test_what_does_not_fit_the_field_is_said_as_it_is_typed(
    kind: str, text: str, said: str
) -> None:
    with pytest.raises(ValueError) as caught:
        parse_field(TypedField("x", kind, None), FormField(), text)
    assert str(caught.value).startswith(said)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("given", "text", "said"),
    [
        (FormField(low=0.0), "nan", "x: at least 0, not nan"),
        (FormField(high=9.0), "nan", "x: at most 9, not nan"),
        (FormField(high=9.0), "inf", "x: at most 9, not inf"),
        (FormField(convert="yaw"), "inf", "x: not a finite number: inf"),
        (FormField(convert="yaw"), "nan", "x: not a finite number: nan"),
    ],
)
def test_what_is_no_number_fits_no_range(given: FormField, text: str, said: str) -> None:
    with pytest.raises(ValueError) as caught:
        parse_field(TypedField("x", "double", None), given, text)
    assert str(caught.value) == said


def test_a_default_value_out_of_range_is_not_offered() -> None:
    shelf = TypedField("shelf_number", "int32", 0)
    assert default_text(shelf, FormField()) == "0"
    assert default_text(shelf, FormField(low=0, high=40)) == "0"
    assert default_text(shelf, FormField(low=1, high=40)) == ""
    assert default_text(TypedField("speed", "double", 1.5), FormField(high=1.0)) == ""
    assert default_text(TypedField("name", "string", "a"), FormField()) == "a"


def test_a_range_tells_the_limits_that_are_known() -> None:
    later = ParameterRef("motor_controller", "shelf_count")
    assert range_text(FormField(low=1.0, high=40.0)) == "1 .. 40"
    assert range_text(FormField(low=0.5, high=later)) == "at least 0.5"
    assert range_text(FormField(high=9999)) == "at most 9999"
    assert range_text(FormField()) == ""
