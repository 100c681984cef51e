"""Messages: fields are checked and copied, arrays of both kinds, bytes as DDS has them."""

from __future__ import annotations

import array
import math
from collections import deque
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Log, Parameter, ParameterDescriptor, ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import (
    Bool,
    Byte,
    Char,
    ColorRGBA,
    Empty,
    Float32,
    Float64,
    Float64MultiArray,
    Header,
    Int32,
    Int32MultiArray,
    Int64,
    MultiArrayDimension,
    MultiArrayLayout,
    String,
    UInt8,
    UInt8MultiArray,
)
from unique_identifier_msgs.msg import UUID

from tests.support.ros import Ros
from tests.support.waiting import wait_until

pytestmark = pytest.mark.pure


def test_fields_start_at_zero_false_and_empty() -> None:
    status = BatteryStatus()
    assert (status.percentage, status.is_charging, status.battery_health) == (0.0, False, "")
    assert list(UUID().uuid) == [0] * 16
    assert ParameterDescriptor().floating_point_range == []


def test_fields_are_given_by_keyword_and_compared_by_value() -> None:
    assert Float32(data=1.5) == Float32(data=1.5)
    assert Float32(data=1.5) != Float32(data=2.5)
    assert Float32(data=1.5) != Float64(data=1.5)  # type: ignore[comparison-overlap]
    assert repr(Float32(data=1.5)) == "std_msgs.msg.Float32(data=1.5)"


def test_constants_stand_on_the_class() -> None:
    assert (Log.WARN, MoveToShelf.Impl.CancelGoalService.Response.ERROR_REJECTED) in (
        (30, 1),
        (b"\x1e", 1),
    )


def test_an_unknown_field_is_refused() -> None:
    with pytest.raises(AssertionError):
        Float32(dta=1.0)  # type: ignore[call-arg]
    with pytest.raises(AttributeError):
        Float32().dta = 1.0  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("message", "field", "value"),
    [
        (Float32(), "data", 1),
        (Float32(), "data", 1e39),
        (Int32(), "data", 1.0),
        (Int32(), "data", 2**31),
        (UInt8(), "data", 256),
        (String(), "data", b"bytes"),
        (BatteryStatus(), "is_charging", 1),
        (ParameterValue(), "string_array_value", [1]),
        (ParameterDescriptor(), "floating_point_range", [1.0]),
        (UUID(), "uuid", [0] * 15),
        (Header(), "stamp", 3),
    ],
)
def test_a_value_of_the_wrong_type_or_range_is_refused(
    message: object, field: str, value: object
) -> None:
    with pytest.raises(AssertionError):
        setattr(message, field, value)


def test_nan_infinity_and_bool_for_an_int_are_taken() -> None:
    assert math.isnan(Float32(data=math.nan).data)
    assert Float32(data=math.inf).data == math.inf
    assert Int32(data=True).data == 1


def test_an_interface_names_its_fields_and_types() -> None:
    assert BatteryStatus.get_fields_and_field_types() == {
        "percentage": "float",
        "voltage": "float",
        "is_charging": "boolean",
        "battery_health": "string",
    }
    assert ParameterValue.get_fields_and_field_types()["double_array_value"] == "sequence<double>"
    assert UUID.get_fields_and_field_types() == {"uuid": "uint8[16]"}


def test_sender_and_receivers_never_share_a_message(ros: Ros) -> None:
    node = ros.node()
    publisher, received = ros.topic(Float32, node)
    others: list[Float32] = []
    node.create_subscription(Float32, "topic", others.append, 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    ros.spin(node)
    message = Float32(data=87.3)
    publisher.publish(message)
    message.data = 2.0
    wait_until(lambda: received and others)
    assert received[0] is not others[0]
    assert received[0].data == others[0].data == 87.30000305175781  # Rounded on the way.


SIXTEEN = list(range(16))


@pytest.mark.parametrize(
    "value",
    [
        [1, 2],
        (1, 2),
        {1, 2},
        deque([1, 2]),
        array.array("i", [1, 2]),
    ],
)
def test_a_sequence_or_a_set_is_taken(value: object) -> None:
    message = Int32MultiArray()
    message.data = value
    assert message.data == array.array("i", [1, 2])


@pytest.mark.parametrize(
    "value",
    [
        {1: 2}.values(),
        (number for number in (1, 2)),
        map(int, (1, 2)),
        [1, "2"],
        [1.0],
        [2**40],
        None,
        3,
    ],
)
def test_what_is_no_sequence_of_such_values_is_refused(value: object) -> None:
    for message in (Int32MultiArray(data=[7]), UInt8MultiArray(data=[7])):
        with pytest.raises(
            AssertionError, match="must be a set or sequence and each value of type"
        ):
            message.data = value
        assert list(message.data) == [7]


def test_integers_in_an_array_of_floats_are_published_as_floats(ros: Ros) -> None:
    node = ros.node()
    publisher, received = ros.topic(Float64MultiArray, node)
    ros.spin(node)
    message = Float64MultiArray(check_fields=False)  # type: ignore[call-arg]  # rosidl's default
    message.data = [0, 1, 2]
    publisher.publish(message)
    wait_until(lambda: received)
    assert [repr(number) for number in received[0].data] == ["0.0", "1.0", "2.0"]


def test_arrays_of_a_fixed_size_are_compared_read_and_set() -> None:
    assert UUID(uuid=SIXTEEN) == UUID(uuid=SIXTEEN) != UUID(uuid=[3] * 16)
    uuid: Any = UUID(uuid=SIXTEEN).uuid
    uuid[0] = 9
    assert uuid.tolist() == [9, *SIXTEEN[1:]]
    assert bytes(uuid) == uuid.tobytes() == bytes(uuid.tolist())
    assert uuid[5:7].tolist() == [5, 6]
    assert (len(uuid), uuid[-1], 15 in uuid) == (16, 15, True)
    for wrong in (-1, 256):
        with pytest.raises(OverflowError):
            uuid[0] = wrong


VALUE = ParameterValue(
    type=9,
    string_array_value=["a", "bcd"],
    double_array_value=[1.0, 2.0],
    byte_array_value=[b"x"],
    bool_array_value=[True, False],
    integer_array_value=[-1],
)
MESSAGES = [
    (String(data="hi"), "0001000003000000686900"),
    (Float64(data=1.5), "00010000000000000000f83f"),
    (Int64(data=-2), "00010000feffffffffffffff"),
    (UInt8MultiArray(data=[1, 2, 3]), "00010000000000000000000003000000010203"),
    (ColorRGBA(r=1.0, g=0.5, a=0.25), "000100000000803f0000003f000000000000803e"),
    (Header(frame_id="map"), "000100000000000000000000040000006d617000"),
    (Bool(data=True), "0001000001"),
    (Byte(data=b"a"), "0001000061"),
    (Char(data=65), "0001000041"),
    (Empty(), "0001000000"),
]


@pytest.mark.parametrize(("message", "text"), MESSAGES, ids=lambda item: type(item).__name__)
def test_a_message_has_the_bytes_that_dds_has(message: Any, text: str) -> None:
    data = serialize_message(message)
    assert data.hex().startswith(text)
    assert len(data) in (len(text) // 2, 8)  # Fast DDS fills the shortest ones up
    assert deserialize_message(bytes.fromhex(text), type(message)) == message


@pytest.mark.parametrize(
    "message",
    [
        Log(stamp=Time(sec=1, nanosec=2), level=30, name="n", msg="mm", file="f", line=4),
        Float64MultiArray(
            layout=MultiArrayLayout(
                dim=[MultiArrayDimension(label="x", size=3, stride=4)], data_offset=7
            ),
            data=[0.5, -1.0],
        ),
        ParameterEvent(node="/n", new_parameters=[Parameter(name="p", value=VALUE)]),
    ],
    ids=lambda message: type(message).__name__,
)
def test_what_is_written_is_read_back_the_same(message: Any) -> None:
    assert deserialize_message(serialize_message(message), type(message)) == message


@pytest.mark.parametrize(
    "data", [b"", b"\0\1\0\0\xff\xff\xff\xff", b"\0\1\0\0\5\0\0\0hi", b"\0\1\0\0"]
)
def test_other_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(RuntimeError, match="failed to deserialize ROS message"):
        deserialize_message(data, String)


def test_a_raw_subscription_gets_bytes_and_bytes_can_be_published(ros: Ros) -> None:
    node = ros.node()
    raw: list[bytes] = []
    texts: list[str] = []
    node.create_subscription(String, "words", raw.append, 10, raw=True)
    node.create_subscription(String, "words", lambda m: texts.append(m.data), 10)
    publisher = node.create_publisher(String, "words", 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    ros.spin(node)
    publisher.publish(String(data="hey"))
    publisher.publish(b"\0\1\0\0\3\0\0\0hi\0")
    wait_until(lambda: len(raw) == len(texts) == 2)
    assert raw == [b"\0\1\0\0\4\0\0\0hey\0", b"\0\1\0\0\3\0\0\0hi\0"]
    assert texts == ["hey", "hi"]
