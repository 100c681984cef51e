"""Rules 1 and 3: messages are copied, fields are checked on assignment."""

from __future__ import annotations

import array
import math

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus
from rcl_interfaces.msg import Log, ParameterDescriptor, ParameterValue, SetParametersResult
from std_msgs.msg import Float32, Float64, Int32, String, UInt8
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
        (Float32(), "data", "1.0"),
        (Float32(), "data", 1e39),
        (Int32(), "data", 1.0),
        (Int32(), "data", 2**31),
        (UInt8(), "data", -1),
        (UInt8(), "data", 256),
        (String(), "data", b"bytes"),
        (BatteryStatus(), "is_charging", 1),
        (SetParametersResult(), "reason", None),
        (ParameterValue(), "string_array_value", [1]),
        (ParameterDescriptor(), "floating_point_range", [1.0]),
        (UUID(), "uuid", [0] * 15),
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


def test_number_arrays_are_kept_as_arrays() -> None:
    value = ParameterValue(double_array_value=[1.0, 2.0])
    assert value.double_array_value == array.array("d", [1.0, 2.0])


def test_an_interface_names_its_fields_and_types() -> None:
    assert BatteryStatus.get_fields_and_field_types() == {
        "percentage": "float",
        "voltage": "float",
        "is_charging": "boolean",
        "battery_health": "string",
    }
    assert ParameterValue.get_fields_and_field_types()["double_array_value"] == "sequence<double>"
    assert UUID.get_fields_and_field_types() == {"uuid": "uint8[16]"}


def test_a_message_that_does_not_exist_is_an_import_error() -> None:
    with pytest.raises(ImportError):
        from std_msgs.msg import NoSuchMessage  # type: ignore[attr-defined]  # noqa: F401


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


def test_an_array_is_copied_too(ros: Ros) -> None:
    node = ros.node()
    publisher, heard = ros.topic(ParameterValue, node)
    ros.spin(node)
    sent = array.array("q", [1, 2, 3])
    message = ParameterValue(integer_array_value=sent)
    publisher.publish(message)
    sent[0] = 99
    message.integer_array_value[1] = 99
    wait_until(lambda: heard)
    assert list(heard[0].integer_array_value) == [1, 2, 3]
