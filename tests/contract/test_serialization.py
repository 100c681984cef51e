"""Messages as CDR bytes: what a bag or a bridge holds; raw subscriptions, and publishing bytes."""

from __future__ import annotations

from typing import Any

import pytest
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import Log, Parameter, ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import (
    Bool,
    Byte,
    Char,
    ColorRGBA,
    Empty,
    Float64,
    Float64MultiArray,
    Header,
    Int64,
    MultiArrayDimension,
    MultiArrayLayout,
    String,
    UInt8MultiArray,
)

from tests.support.ros import Ros
from tests.support.waiting import wait_until

pytestmark = pytest.mark.pure

VALUE = ParameterValue(
    type=9,
    string_array_value=["a", "bcd"],
    double_array_value=[1.0, 2.0],
    byte_array_value=[b"x"],
    bool_array_value=[True, False],
    integer_array_value=[-1],
)
VALUES_BYTES = (
    "0001000009000000000000000000000000000000000000000000000001000000000000000100000078000000"
    "02000000010000000100000000000000ffffffffffffffff0200000000000000000000000000f03f00000000"
    "000000400200000002000000610000000400000062636400"
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


def test_what_stands_between_the_fields_is_not_read() -> None:
    assert deserialize_message(bytes.fromhex(VALUES_BYTES), ParameterValue) == VALUE


def test_big_endian_is_read_too() -> None:
    assert deserialize_message(b"\0\0\0\0\0\0\0\3hi\0", String) == String(data="hi")


@pytest.mark.parametrize(
    "data", [b"", b"\0\1\0\0\xff\xff\xff\xff", b"\0\1\0\0\5\0\0\0hi", b"\0\1\0\0"]
)
def test_other_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(RuntimeError, match="failed to deserialize ROS message"):
        deserialize_message(data, String)


def test_what_is_no_message_and_no_bytes_is_refused() -> None:
    with pytest.raises(AttributeError):
        serialize_message(3)
    with pytest.raises(AttributeError):
        deserialize_message(b"\0\1\0\0", int)
    with pytest.raises(TypeError):
        deserialize_message("text", String)  # type: ignore[arg-type]


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
