"""What goes into a message is what was meant, or is refused in one line that says why.

rosidl does not check it: see `_own_folders` in conftest.py.
"""

from __future__ import annotations

import random
import struct
from typing import Any

import pytest
from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Float32, Int8
from unique_identifier_msgs.msg import UUID

from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.base.yaml_text.dump import block
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.messages.values import checked, filled, put
from archo_tui.robot.outcome import Code
from tests.support import chosen
from tests.support.night import corners
from tests.support.quiet import ended
from tests.support.robot import robot
from tests.support.values import installed, told, values_of

LONG = 10**30
REFUSED = [
    ("int32", 3_000_000_000, "3000000000 is not within -2147483648 .. 2147483647"),
    ("int8", 300, "300 is not within -128 .. 127"),
    ("int8", -129, "-129 is not within -128 .. 127"),
    ("uint8", -1, "-1 is not within 0 .. 255"),
    ("uint64", 2**64, "18446744073709551616 is not within 0 .. 18446744073709551615"),
    ("int64", LONG, f"{LONG} is not within -9223372036854775808 .. 9223372036854775807"),
    ("int32", 1.0, "1.0 is not a whole number"),
    ("int32", True, "true is not a whole number"),
    ("int32", "1", '"1" is not a whole number'),
    ("int32", None, "null is not a whole number"),
    ("octet", 256, "256 is not within 0 .. 255"),
    ("octet", b"ab", '!!binary "YWI=" is not a whole number'),
    ("boolean", 1, "1 is not true or false"),
    ("boolean", "yes", '"yes" is not true or false'),
    ("float", 1e39, "1.0e+39 is not within -3.402823466e+38 .. 3.402823466e+38"),
    ("float", "fast", "fast is not a number"),
    ("double", True, "true is not a number"),
    ("double", 10**400, "is too large for a number"),
    ("double", {"x": 0.0}, "{x: 0.0} is not a number"),
    ("double", None, "null is not a number"),
    ("string", 12, "12 is not a text"),
    ("string", "a\0b", '"a\\0b" contains a null character'),
    ("string", "\ud800", '"\\uD800" contains half of a surrogate pair'),
    ("wstring", "\udfff", '"\\uDFFF" contains half of a surrogate pair'),
    ("string<8>", "123456789012", '"123456789012" has 12 characters, at most 8'),
    ("wstring<2>", "日本語", '"日本語" has 3 characters, at most 2'),
    ("wstring", "\ufeffa", "begins with a byte order mark, which ROS removes"),
    ("sequence<wstring<4>>", ["\ufffea"], "begins with a byte order mark"),
    ("uint8[4]", [1], "[1] has 1 elements, not 4"),
    ("uint8[2]", [1, 2, 3], "[1, 2, 3] has 3 elements, not 2"),
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
    from rcl_interfaces.srv import SetParameters

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


class Heard(Node):
    """Keeps what it is asked for."""

    def __init__(self, srv_type: Any, **options: Any) -> None:
        super().__init__("heard", **options)
        self.requests: list[Any] = []
        self.create_service(srv_type, "ask", self.answer)

    def answer(self, request: Any, response: Any) -> Any:
        self.requests.append(request)
        return response


@pytest.mark.parametrize("name", ["SetParameters", "DescribeParameters", "GetParameterTypes"])
async def test_a_server_receives_the_values_that_were_typed(name: str) -> None:
    kind, made = f"rcl_interfaces/srv/{name}", list[Heard]()

    def maker(**options: Any) -> Node:
        made.append(Heard(load_class(kind), **options))
        return made[-1]

    chance = random.Random(name)
    async with robot(maker) as it:
        for _ in range(20):
            values = values_of(load_class(kind).Request, chance)
            typed = bounded_yaml.load(block(values))
            assert (await ended(it.call("ask", kind, typed))).text != ""
            assert told(made[0].requests[-1]) == told(values)


async def test_a_value_that_does_not_fit_is_never_sent() -> None:
    kind, made = "rcl_interfaces/srv/SetParameters", list[Heard]()

    def maker(**options: Any) -> Node:
        made.append(Heard(load_class(kind), **options))
        return made[-1]

    async with robot(maker) as it:
        wrong = {"parameters": [{"name": "x", "value": {"type": 300}}]}
        outcome = await ended(it.call("ask", kind, wrong))
        assert outcome == (Code.MISUSE, "parameters[0].value.type: 300 is not within 0 .. 255")
        assert made[0].requests == []
