"""Arrays in messages: what may be assigned, what is kept of it, and those of a fixed size."""

from __future__ import annotations

import array
import copy
import pickle
from collections import UserList, deque
from typing import Any

import pytest
from rcl_interfaces.msg import FloatingPointRange, ListParametersResult, ParameterDescriptor
from std_msgs.msg import Float64MultiArray, Int32MultiArray, UInt8MultiArray
from unique_identifier_msgs.msg import UUID

from tests.support.ros import Ros
from tests.support.waiting import wait_until

pytestmark = pytest.mark.pure

SIXTEEN = list(range(16))


@pytest.mark.parametrize(
    "value",
    [
        [1, 2],
        (1, 2),
        {1, 2},
        range(1, 3),
        deque([1, 2]),
        UserList([1, 2]),
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
        {1: 2},
        {1: 2}.values(),
        (number for number in (1, 2)),
        map(int, (1, 2)),
        "12",
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


def test_an_integer_that_no_float_holds_is_refused_by_an_error() -> None:
    message = Float64MultiArray(check_fields=False)  # type: ignore[call-arg]
    with pytest.raises((AssertionError, OverflowError), match=r"float|double"):
        message.data = [1, 10**310]
    with pytest.raises((AssertionError, OverflowError), match="float"):
        Float64MultiArray(data=[1, 10**310])


def test_an_array_of_another_type_code_is_refused() -> None:
    for code in "hqd":
        with pytest.raises(AssertionError, match="must have the type code of 'i'"):
            Int32MultiArray().data = array.array(code, [1])


def test_what_is_wrong_with_an_array_names_its_length_and_its_limits() -> None:
    with pytest.raises(AssertionError, match=r"\[-2147483648, 2147483647\]"):
        Int32MultiArray().data = ["x"]
    with pytest.raises(AssertionError, match="with length <= 1 and each value of type 'Floating"):
        ParameterDescriptor().floating_point_range = [FloatingPointRange()] * 2
    with pytest.raises(AssertionError, match="with length 16 and each value of type 'int'"):
        UUID().uuid = [1] * 15


def test_a_list_that_was_assigned_can_be_filled_until_it_is_sent(ros: Ros) -> None:
    node = ros.node()
    publisher, heard = ros.topic(ListParametersResult, node)
    ros.spin(node)
    names: Any = ["a"]
    message = ListParametersResult(names=names, prefixes={"c"})  # type: ignore[arg-type]
    names.append("b")
    publisher.publish(message)
    names.append("too late")
    wait_until(lambda: heard)
    assert (heard[0].names, heard[0].prefixes) == (["a", "b"], ["c"])


def test_messages_with_arrays_of_a_fixed_size_are_compared() -> None:
    one, same, other = (UUID(uuid=values) for values in (SIXTEEN, SIXTEEN, [3] * 16))
    assert one == same
    assert one != other
    assert one.uuid.tolist() == SIXTEEN


def test_their_elements_are_read_and_set() -> None:
    uuid: Any = UUID(uuid=SIXTEEN).uuid
    uuid[0] = 9
    assert uuid.tolist() == [9, *SIXTEEN[1:]]
    assert bytes(uuid) == uuid.tobytes() == bytes(uuid.tolist())
    assert uuid[5:7].tolist() == [5, 6]
    assert (len(uuid), uuid[-1], 15 in uuid) == (16, 15, True)
    for wrong in (-1, 256):
        with pytest.raises(OverflowError):
            uuid[0] = wrong


def test_bytes_are_no_array_of_a_fixed_size_but_an_array_of_bytes_is() -> None:
    with pytest.raises(ValueError, match=r"bytes|invalid literal for int"):
        UUID().uuid = bytes(16)
    for value in (bytearray(SIXTEEN), array.array("B", SIXTEEN), array.array("h", SIXTEEN)):
        assert UUID(uuid=value).uuid.tolist() == SIXTEEN


def test_one_that_is_assigned_is_shared_and_a_copy_is_not() -> None:
    one, other = UUID(uuid=SIXTEEN), UUID()
    other.uuid = one.uuid
    one.uuid[0] = 77
    assert other.uuid[0] == 77
    for alone in (
        copy.deepcopy(one),
        pickle.loads(pickle.dumps(one)),
        UUID(uuid=one.uuid.tolist()),
    ):
        alone.uuid[0] = 3
        assert one.uuid[0] == 77
        assert alone.uuid.tolist() == [3, *SIXTEEN[1:]]
    with pytest.raises(AssertionError, match=r"must have a size of 16|with length 16"):
        other.uuid = one.uuid[:8]
