"""What is asked of a service and answered, told on a topic of its own."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.action import ActionClient, ActionServer
from rclpy.qos import qos_profile_system_default
from rclpy.service_introspection import ServiceIntrospectionState
from std_srvs.srv import SetBool

from tests.support.ros import Ros
from tests.support.waiting import wait_until

OFF, METADATA, CONTENTS = (
    ServiceIntrospectionState.OFF,
    ServiceIntrospectionState.METADATA,
    ServiceIntrospectionState.CONTENTS,
)


def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    response.success, response.message = request.data, "done"
    return response


@pytest.mark.parametrize("state", [METADATA, CONTENTS])
def test_four_events_tell_of_a_call(ros: Ros, state: ServiceIntrospectionState) -> None:
    events: list[Any] = []
    node = ros.node()
    service = node.create_service(SetBool, "switch", answer)
    client = node.create_client(SetBool, "switch")
    own = len(list(node.publishers))
    for one in (service, client):
        one.configure_introspection(node.get_clock(), qos_profile_system_default, state)
    assert len(list(node.publishers)) == own
    node.create_subscription(SetBool.Event, "switch/_service_event", events.append, 10)
    wait_until(lambda: node.count_publishers("switch/_service_event") == 2)
    wait_until(client.service_is_ready)
    ros.spin(node)
    assert ros.result(client.call_async(SetBool.Request(data=True))).message == "done"
    wait_until(lambda: len(events) == 4)
    events.sort(key=lambda event: event.info.event_type)
    assert [event.info.event_type for event in events] == [0, 1, 2, 3]
    assert {event.info.sequence_number for event in events} == {1}
    assert len({bytes(map(int, event.info.client_gid)) for event in events}) == 1
    assert all(event.info.stamp.sec > 0 for event in events)
    asked = [[message.data for message in event.request] for event in events]
    answered = [[message.message for message in event.response] for event in events]
    if state == CONTENTS:
        assert (asked, answered) == ([[True], [True], [], []], [[], [], ["done"], ["done"]])
    else:
        assert asked == answered == [[], [], [], []]


def test_who_is_switched_off_or_destroyed_tells_nothing(ros: Ros) -> None:
    node = ros.node()
    service = node.create_service(SetBool, "switch", answer)
    client = node.create_client(SetBool, "switch")
    for one in (service, client):
        one.configure_introspection(node.get_clock(), qos_profile_system_default, METADATA)
    wait_until(lambda: node.count_publishers("switch/_service_event") == 2)
    client.configure_introspection(node.get_clock(), qos_profile_system_default, OFF)
    wait_until(lambda: node.count_publishers("switch/_service_event") == 1)
    node.destroy_service(service)
    wait_until(lambda: node.count_publishers("switch/_service_event") == 0)
    with pytest.raises(InvalidHandle):
        service.configure_introspection(node.get_clock(), qos_profile_system_default, OFF)


def test_an_actions_three_services_are_told_too(ros: Ros) -> None:
    node = ros.node()
    ends: list[Any] = [
        ActionServer(node, MoveToShelf, "move", print),
        ActionClient(node, MoveToShelf, "move"),
    ]
    for one in ends:
        one.configure_introspection(node.get_clock(), qos_profile_system_default, METADATA)
    for name in ("send_goal", "cancel_goal", "get_result"):
        topic = f"move/_action/{name}/_service_event"
        wait_until(lambda topic=topic: node.count_publishers(topic) == 2)  # type: ignore[misc]


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ((None, qos_profile_system_default, METADATA), AttributeError),
        ((..., 10, METADATA), AttributeError),
        ((..., qos_profile_system_default, 1), TypeError),
    ],
)
def test_what_is_no_clock_profile_or_state_is_refused(
    ros: Ros, given: tuple[Any, ...], error: type[Exception]
) -> None:
    node = ros.node()
    client = node.create_client(SetBool, "switch")
    clock, *others = given
    with pytest.raises(error):
        client.configure_introspection(node.get_clock() if clock is ... else clock, *others)


def test_an_event_holds_one_request_and_one_response() -> None:
    assert SetBool.Event.get_fields_and_field_types() == {
        "info": "service_msgs/ServiceEventInfo",
        "request": "sequence<std_srvs/SetBool_Request, 1>",
        "response": "sequence<std_srvs/SetBool_Response, 1>",
    }
    with pytest.raises(AssertionError):
        SetBool.Event(request=[SetBool.Request(), SetBool.Request()])
