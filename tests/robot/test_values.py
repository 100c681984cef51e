"""What a typed or given value means for a field or a parameter, or why it means nothing, in a line.

rosidl does not check it: see `_own_folders` in conftest.py.
"""

from __future__ import annotations

import math
import random
import struct
from typing import Any

import pytest
from action_msgs.srv import CancelGoal
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Float32, Int8
from unique_identifier_msgs.msg import UUID

from archo_tui.robot.graph import parameter_values
from archo_tui.robot.graph.parameter_values import fit
from archo_tui.robot.messages.typed import default_text, parse_field, range_text
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.messages.values import checked, filled, goal_request, put, text_of
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.graph import Parameter
from archo_tui.robot_file.model import FormField, GoalKind, ParameterRef
from tests.support import chosen
from tests.support.night import corners
from tests.support.quiet import ended, until
from tests.support.robot import robot
from tests.support.stand_in import Made
from tests.support.values import installed, told, values_of


def parameter(kind: str, **options: Any) -> Parameter:
    return Parameter("/node", "name", kind, None, None, **options)


def field(kind: str, text: str, given: FormField | None = None) -> Any:
    return parse_field(TypedField("x", kind, None), given or FormField(), text)


# A typed text.

TYPES = {"boolean": "bool", "int64": "integer", "double": "double", "string": "string"}
TYPES |= {f"sequence<{of}>": f"{kind}[]" for of, kind in TYPES.items()}


@pytest.mark.pure
@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        *(("int64", " +12 ", 12), ("int64", f"{'0' * 40}12", 12), ("int64", "010", 10)),
        *(("double", "1", 1.0), ("double", " .5 ", 0.5), ("double", "-5.", -5.0)),
        *(("double", "+1.5e-3", 0.0015), ("double", "-.inf", -math.inf)),
        *(("boolean", "Yes", True), ("boolean", "off", False)),
        *(("string", "yes", "yes"), ("string", "", ""), ("string", " spaced ", " spaced ")),
        *(("sequence<int64>", "[]", []), ("sequence<int64>", "[1, -2, 010]", [1, -2, 10])),
        ("sequence<double>", "[1, .5, 1e3, .inf]", [1.0, 0.5, 1000.0, math.inf]),
        ("sequence<boolean>", "[on, false, no]", [True, False, False]),
        ("sequence<string>", "[a, 'b c', 010, yes]", ["a", "b c", "010", "yes"]),
        # Of messages only, where infinity needs no dot.
        *(("double[2]", "[1e3, +2]", [1000.0, 2.0]), ("float", "inf", math.inf)),
        *(("sequence<string<3>, 3>", "[abc]", ["abc"]), ("sequence<octet>", "[0, 255]", [0, 255])),
        ("sequence<float>", "[inf, -.Inf]", [math.inf, -math.inf]),
    ],
)
def test_the_type_of_a_field_or_a_parameter_decides(kind: str, text: str, value: Any) -> None:
    found = [field(kind, text)]
    if kind in TYPES:
        found.append(parameter_values.parse(parameter(TYPES[kind]), text))
    assert found == [value] * len(found)
    assert all(type(one) is type(value) for one in found)


@pytest.mark.pure
@pytest.mark.parametrize("text", ["1_2", "０５", "٣", "1_0.5", "infinity", "0x10", "1 2", "--1"])
@pytest.mark.parametrize(
    ("kind", "what"),
    [("int32", "a whole number"), ("double", "a number"), ("sequence<double>", "a list")],
)
def test_what_only_python_or_yaml_takes_is_no_number(kind: str, what: str, text: str) -> None:
    typed = f"[{text}]" if what == "a list" else text
    with pytest.raises(ValueError) as caught:
        field(kind, typed, FormField(label="Way"))
    assert str(caught.value) == f"Way: not {what}: {typed}"


@pytest.mark.pure
@pytest.mark.parametrize("text", ["nan", ".nan", ".NaN"])
def test_nan_is_the_same_in_a_field_and_in_a_list(text: str) -> None:
    assert math.isnan(field("float", text))
    assert math.isnan(field("sequence<float>", f"[{text}]")[0])


@pytest.mark.pure
@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("int32", "3000000000", "x: at most 2147483647, not 3000000000"),
        ("uint8[4]", "[1]", "x: [1] has 1 elements, not 4"),
        ("sequence<int64>", "[true]", "x: not a list: [true]"),
        ("sequence<int64>", "[1:30]", "x: not a list: [1:30]"),
        ("sequence<string>", "[[a]]", "x: not a list of single values: [[a]]"),
        ("sequence<int8>", "&a [*a]", "x: aliases (*a) are not read: write it out: &a [*a]"),
        ("sequence<int8>", "[" * 9000, f"x: nested more than 20 deep: {'[' * 20} ..."),
        ("sequence<a_msgs/A>", "[" * 9000, f"x: nested more than 20 deep: {'[' * 20} ..."),
        ("string", "a" * 10_001, "x: 10001 characters, at most 10000"),
        ("sequence<string>", f"[{'a' * 10_000}]", "x: 10002 characters, at most 10000"),
        ("builtin_interfaces/Time[1]", "[{sec: 1, sec: 2}]", "x: sec is given twice: "),
        ("builtin_interfaces/Time[1]", "[{sec: 1.5}]", "x[0].sec: 1.5 is not a whole number"),
    ],
)
def test_what_does_not_fit_the_field_is_said_as_it_is_typed(
    kind: str, text: str, said: str
) -> None:
    with pytest.raises(ValueError) as caught:
        field(kind, text)
    assert str(caught.value).startswith(said)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.pure
@pytest.mark.parametrize(
    ("given", "text", "said"),
    [
        (FormField(low=0.0), "nan", "x: at least 0, not nan"),
        (FormField(high=9.0), "inf", "x: at most 9, not inf"),
        (FormField(convert="yaw"), "nan", "x: not a finite number: nan"),
    ],
)
def test_what_is_no_number_fits_no_range(given: FormField, text: str, said: str) -> None:
    with pytest.raises(ValueError) as caught:
        field("double", text, given)
    assert str(caught.value) == said


@pytest.mark.pure
def test_a_default_value_out_of_range_is_not_offered() -> None:
    shelf = TypedField("shelf_number", "int32", 0)
    assert default_text(shelf, FormField()) == "0"
    assert default_text(shelf, FormField(low=0, high=40)) == "0"
    assert default_text(shelf, FormField(low=1, high=40)) == ""
    assert default_text(TypedField("speed", "double", 1.5), FormField(high=1.0)) == ""
    assert default_text(TypedField("name", "string", "a"), FormField()) == "a"


@pytest.mark.pure
def test_a_range_tells_the_limits_that_are_known() -> None:
    later = ParameterRef("motor_controller", "shelf_count")
    assert range_text(FormField(low=1.0, high=40.0)) == "1 .. 40"
    assert range_text(FormField(low=0.5, high=later)) == "at least 0.5"
    assert range_text(FormField(high=9999)) == "at most 9999"
    assert range_text(FormField()) == ""


# A parameter's value.


@pytest.mark.pure
@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("double", "", "a value is needed (double)"),
        ("double", "fast", "not a number: fast"),
        ("double", "NaN", "not a finite number: NaN"),
        ("double", "1_0.5", "not a number: 1_0.5"),
        ("double", "inf", "not a finite number: inf"),
        ("double", ".", "not a number: ."),
        ("integer", "1.0", "not a whole number: 1.0"),
        ("integer", "9" * 5000, f"too large for an integer: {'9' * 5000}"),
        ("integer", "9223372036854775808", "too large for an integer: 9223372036854775808"),
        ("bool", "2", "not true or false: 2"),
        ("integer[]", "1, 2", "not a list like [1, 2]: 1, 2"),
        ("integer[]", "[1, 1:30]", "not a whole number: 1:30"),
        ("double[]", "[1_0.5]", "not a number: 1_0.5"),
        ("string", "bell\x07", "control characters are not allowed"),
        ("string", "x" * 10_001, "too long: 10001 characters, at most 10000"),
        ("byte[]", "[1]", "a parameter of type byte[] cannot be edited here"),
    ],
)
def test_what_means_nothing_for_a_parameter_is_said_in_one_line(
    kind: str, text: str, said: str
) -> None:
    with pytest.raises(ValueError) as caught:
        parameter_values.parse(parameter(kind), text)
    assert str(caught.value) == said


@pytest.mark.pure
def test_ranges_and_read_only() -> None:
    limited = parameter("double", low=0.05, high=2.0)
    assert parameter_values.range_text(limited) == "0.05 .. 2"
    exact = limited._replace(low=0.1234567, high=1234567)
    assert parameter_values.range_text(exact) == "0.1234567 .. 1234567"
    assert parameter_values.parse(limited, "2") == 2.0
    with pytest.raises(ValueError, match=r"allowed 0.05 .. 2, not 2.01"):
        parameter_values.parse(limited, "2.01")
    with pytest.raises(ValueError, match="read-only"):
        parameter_values.parse(parameter("integer", read_only=True), "1")
    for outside in (math.nan, math.inf):
        with pytest.raises(ValueError, match=r"allowed 0.05 .. 2, not"):
            fit(limited, outside)


@pytest.mark.pure
def test_values_read_as_they_are_written() -> None:
    assert [text_of(v) for v in (True, 1, 0.5, "x", [1.0, False])] == [
        "true", "1", "0.5", "x", "[1.0, false]"
    ]  # fmt: skip


DECLARED = {
    **{"count": 3, "speed": 0.5, "name": "a", "on": False},
    **{"counts": [1, 2], "speeds": [0.5], "names": ["a"], "bits": [b"\x01", b"\xff"]},
}


class Tunable(Node):
    """Has a parameter of each type."""

    def __init__(self, **options: Any) -> None:
        super().__init__("tunable", **options)
        for name, value in DECLARED.items():
            self.declare_parameter(name, value)

    def has(self, name: str) -> Any:
        value = self.get_parameter(name).value
        return value if isinstance(value, str) or not hasattr(value, "__len__") else list(value)


async def test_a_node_gets_the_value_that_was_meant_or_the_console_says_why_not() -> None:
    tunable = Made(Tunable)
    async with robot(tunable) as it:
        await until(lambda: it.snapshot.parameter("count") is not None)
        for name, value in (
            *(("count", 2**63 - 1), ("count", -(2**63)), ("speed", 1e300), ("speed", math.inf)),
            *(("name", "yes"), ("name", "it's\n\u2028 \U0001f600"), ("counts", [2**63 - 1, 0])),
            *(("counts", []), ("speeds", []), ("names", []), ("names", ["", "1"])),
            ("bits", [b"\x00", b"\x80"]),
        ):
            outcome = await ended(it.set_parameters("/tunable", {name: value}))
            assert outcome.ok, outcome.text
            assert tunable.node.has(name) == value
        before = [tunable.node.has(name) for name in DECLARED]
        for name, value, said in (
            ("count", 2**63, "count: 9223372036854775808 is not within -9223372036854775808 .. "),
            ("counts", [1, -(2**63) - 1], "counts[1]: -9223372036854775809 is not within"),
            ("name", "a\0b", 'name: "a\\0b" contains a null character'),
            ("names", ["a", "\ud800"], 'names[1]: "\\uD800" contains half of a surrogate pair'),
        ):
            outcome = await ended(it.set_parameters("/tunable", {"on": True, name: value}))
            assert outcome.code == Code.MISUSE
            assert outcome.text.startswith(said)
            assert [tunable.node.has(name) for name in DECLARED] == before


# A value of a message.


LONG = 10**30
REFUSED = [
    ("int32", 3_000_000_000, "3000000000 is not within -2147483648 .. 2147483647"),
    ("int8", 300, "300 is not within -128 .. 127"),
    ("uint8", -1, "-1 is not within 0 .. 255"),
    ("int64", LONG, f"{LONG} is not within -9223372036854775808 .. 9223372036854775807"),
    ("int32", 1.0, "1.0 is not a whole number"),
    ("int32", True, "true is not a whole number"),
    ("int32", "1", '"1" is not a whole number'),
    ("octet", b"ab", '!!binary "YWI=" is not a whole number'),
    ("boolean", 1, "1 is not true or false"),
    ("float", 1e39, "1.0e+39 is not within -3.402823466e+38 .. 3.402823466e+38"),
    ("float", "fast", "fast is not a number"),
    ("double", 10**400, "is too large for a number"),
    ("double", {"x": 0.0}, "{x: 0.0} is not a number"),
    ("string", 12, "12 is not a text"),
    ("string", "a\0b", '"a\\0b" contains a null character'),
    ("string", "\ud800", '"\\uD800" contains half of a surrogate pair'),
    ("string<8>", "123456789012", '"123456789012" has 12 characters, at most 8'),
    ("wstring", "\ufeffa", "begins with a byte order mark, which ROS removes"),
    ("sequence<wstring<4>>", ["\ufffea"], "begins with a byte order mark"),
    ("uint8[4]", [1], "[1] has 1 elements, not 4"),
    ("uint8[2]", b"ab", '!!binary "YWI=" is not a list'),
    ("sequence<int16, 2>", [1, 2, 3], "[1, 2, 3] has 3 elements, at most 2"),
    ("sequence<int16>", "12", '"12" is not a list'),
    ("sequence<int64>", [1, True], "[1]: true is not a whole number"),
    ("sequence<float>", [0, 1e39], "[1]: 1.0e+39 is not within"),
    ("sequence<string<3>, 2>", ["abc", "abcd"], "[1]: abcd has 4 characters, at most 3"),
    ("sequence<string<3>, 1>", ["a", "b"], "[a, b] has 2 elements, at most 1"),
    ("builtin_interfaces/Time", 3, "3 is not the fields of builtin_interfaces/Time"),
    ("sequence<builtin_interfaces/Time>", [{"sec": 2**31}], "[0].sec: 2147483648 is not within"),
    ("builtin_interfaces/Time[2]", [{}], "[{}] has 1 elements, not 2"),
    ("nobody_msgs/Nothing", {}, "nobody_msgs/Nothing is not installed here"),
    ("long double", 1.0, "a field of type long double, which cannot be set from here"),
]


def test_what_does_not_fit_its_field_is_refused_in_one_line() -> None:
    for kind, value, said in REFUSED:
        with pytest.raises(ValueError) as caught:
            checked(kind, value, "x")
        line = str(caught.value)
        assert line.startswith("x"), (kind, value)
        assert said in line, (kind, value)
        assert len(line.splitlines()) == 1, (kind, value)


def test_the_largest_number_of_four_bytes_is_sent_as_it_is() -> None:
    for largest in (3.4028234663852886e38, -3.4028234663852886e38):
        sent = checked("float", largest, "x")
        assert struct.unpack("f", struct.pack("f", sent)) == (largest,)
        assert Float32(data=sent).data == sent  # which the embedded engine checks as rosidl does


@pytest.mark.parametrize(
    "values",
    [
        {"goal_info.stamp.sec": 1, "goal_info.stamp": {"nanosec": 2}},
        {"goal_info.stamp": {"nanosec": 2}, "goal_info.stamp.sec": 1},
        {"goal_info": {"stamp.sec": 1, "stamp": {}}},
        {"goal_info": {}, "goal_info.stamp": {}},
    ],
)
def test_what_is_given_twice_is_refused_and_not_overwritten(values: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"stamp(.sec)? is given twice, also by "):
        filled(CancelGoal.Request(), values)


@pytest.mark.skipif(chosen.ENGINE != "ros2", reason="the embedded engine always checks")
def test_nobody_else_checks_what_the_console_sends() -> None:
    assert Int8(data=300).data == 300
    assert UUID(uuid=[1]).uuid.tolist() == [1]


def test_a_wrong_value_of_any_length_is_shown_in_short() -> None:
    with pytest.raises(ValueError) as caught:
        checked("sequence<int8>", "x" * 10_000, "x")
    assert str(caught.value) == f"x: {'x' * 40} ... is not a list"


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("parameters", [{"value": {"integer_value": 2**63}}], "parameters[0].value.integer_value"),
        ("parameters", [{"value": {"integer": 1}}], "no field parameters[0].value.integer: "),
        ("parameter", [], "there is no field parameter: parameters"),
        ("parameters.x", 1, "no field parameters.x: parameters is of type sequence<"),
    ],
)
def test_the_line_names_the_field_by_its_whole_path(path: str, value: Any, said: str) -> None:
    with pytest.raises(ValueError) as caught:
        put(SetParameters.Request(), path, value)
    assert said in str(caught.value)


@pytest.mark.parametrize("name", corners(sorted(installed())[::5], sorted(installed())))
def test_random_values_of_every_type_travel_unaltered(name: str) -> None:
    message_class, chance = installed()[name], random.Random(name)
    for _ in range(30):
        values = values_of(message_class, chance)
        message = filled(message_class(), values)
        received = deserialize_message(serialize_message(message), message_class)
        assert told(received) == told(values)


# A goal of the robot file: what it fixes and converts is checked as what is typed is.


def test_a_goal_is_made_of_what_is_fixed_converted_and_typed() -> None:
    actions = pytest.importorskip("depot_interfaces.action")
    yaw = {"target.pose.orientation": FormField(label="yaw", convert="yaw")}

    def goal(name: str, form: Any, fixed: Any, values: Any) -> Any:
        kind = GoalKind("go", "Go", "go", f"depot_interfaces/action/{name}", form=form, fixed=fixed)
        return goal_request(getattr(actions, name), kind, values)

    turned = goal("GoTo", yaw, {}, {"target.pose.orientation": 90.0}).target.pose.orientation
    assert (turned.x, turned.y) == (0.0, 0.0)
    assert math.degrees(2 * math.atan2(turned.z, turned.w)) == pytest.approx(90.0)
    x = "target.pose.position.x"
    for name, form, fixed, values, said in (
        ("GoTo", {x: FormField(convert="yaw")}, {}, {x: 90.0}, f"{x}: {{x: 0.0, y: 0.0, z: 0."),
        ("Haul", {"bay": FormField(convert="yaw")}, {}, {"bay": 90.0}, "is not a whole number"),
        ("GoTo", yaw, {}, {"target.pose.orientation": math.inf}, ".inf is not a finite number"),
        ("GoTo", yaw, {}, {"target.pose.orientation": "north"}, "north is not a number"),
        ("Haul", {}, {"bay": 2**31}, {}, "bay: 2147483648 is not within -2147483648 .. 2147483647"),
        ("Haul", {}, {"bay": True}, {}, "bay: true is not a whole number"),
        ("GoTo", {}, {"target.frame_id": 1}, {}, "target.frame_id: 1 is not a text"),
        ("GoTo", {}, {"target.pose": {"positon": {}}}, {}, "there is no field target.pose.positon"),
        ("Inspect", {}, {"labels": ["a", None]}, {}, "labels[1]: null is not a text"),
    ):
        with pytest.raises(ValueError) as caught:
            goal(name, form, fixed, values)
        assert said in str(caught.value)
