"""What can be read, written and called of the things that a node makes, and what cannot."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient
from rclpy.exceptions import InvalidHandle
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Float32MultiArray, Header, Int32
from std_srvs.srv import Trigger

from tests.support.ros import Ros

DESCRIBES_TYPES = "start_type_description_service"


@pytest.fixture
def made(ros: Ros) -> dict[str, Any]:
    """One of each that a node makes."""
    node = ros.node()
    return {
        "publisher": node.create_publisher(Int32, "a", 10),
        "subscription": node.create_subscription(Int32, "a", lambda _: None, 10),
        "service": node.create_service(Trigger, "s", lambda request, response: response),
        "client": node.create_client(Trigger, "s"),
        "timer": node.create_timer(1.0, lambda: None),
    }


@pytest.mark.parametrize(
    ("what", "names"),
    [
        ("publisher", ("topic_name", "logger_name")),
        ("subscription", ("topic_name", "logger_name")),
        ("service", ("service_name", "logger_name")),
        ("client", ("service_name", "logger_name")),
        ("timer", ("clock",)),
    ],
)
def test_what_the_graph_knows_is_read_only(
    made: dict[str, Any], what: str, names: tuple[str, ...]
) -> None:
    for name in names:
        with pytest.raises(AttributeError):
            setattr(made[what], name, None)


def test_what_was_destroyed_has_no_name_on_the_graph(made: dict[str, Any]) -> None:
    for what, name in (("publisher", "topic_name"), ("client", "service_name")):
        made[what].destroy()
        with pytest.raises(InvalidHandle):
            getattr(made[what], name)


def test_a_client_knows_its_requests_that_wait(ros: Ros) -> None:
    node = ros.node()
    client = node.create_client(Trigger, "s")
    assert client.context is ros.context
    future = client.call_async(Trigger.Request())
    future.cancel()
    assert future.cancelled()


def test_a_negative_wait_for_others_is_over_at_once(ros: Ros) -> None:
    node = ros.node()
    client = node.create_client(Trigger, "s")
    assert client.wait_for_service(-1.0) is False
    assert AsyncParameterClient(node, "nobody").wait_for_services(-1.0) is False
    mover = ActionClient(node, MoveToShelf, "move")
    assert mover.wait_for_server(-1.0) is False
    mover.destroy()


def test_an_answer_goes_to_the_header_of_a_request(made: dict[str, Any]) -> None:
    with pytest.raises(TypeError):
        made["service"].send_response(Trigger.Response(), 3)


def test_behind_shutdown_a_callback_for_it_is_called_at_once(ros: Ros) -> None:
    called: list[str] = []
    ros.context.on_shutdown(lambda: called.append("then"))
    ros.context.try_shutdown()
    assert called == ["then"]
    ros.context.on_shutdown(lambda: called.append("late"))
    assert called == ["then", "late"]


def test_arguments_that_ros_does_not_know_are_refused_when_they_are_removed() -> None:
    assert remove_ros_args(["x", "--ros-args", "-r", "a:=b", "--", "y"]) == ["x", "y"]
    with pytest.raises(RuntimeError, match="--bad"):
        remove_ros_args(["x", "--ros-args", "--bad"])


def test_numbers_are_converted_when_an_array_is_made() -> None:
    message = Float32MultiArray(data=[1, 2])
    assert message.data.tolist() == [1.0, 2.0]
    assert Float32MultiArray(data=map(float, "12")) == message
    with pytest.raises(AssertionError, match="each value of type 'float'"):
        message.data = ["x"]
    with pytest.raises((AssertionError, TypeError)):
        Float32MultiArray(data=["x"])


def test_a_message_within_a_message_is_asked_for_by_its_name() -> None:
    with pytest.raises(AssertionError, match="must be a sub message of type 'Time'"):
        Header(stamp=3)  # type: ignore[arg-type]


def test_a_node_has_two_parameters_from_the_start(ros: Ros) -> None:
    node = ros.node()
    assert node.list_parameters([], 0).names == [
        "use_sim_time",
        DESCRIBES_TYPES,
    ]
    assert node.get_parameter_type(DESCRIBES_TYPES) == 1
    assert node.describe_parameter(DESCRIBES_TYPES).read_only
    said: Parameter[bool] = Parameter(DESCRIBES_TYPES, value=False)
    assert "read-only" in node.set_parameters([said])[0].reason
