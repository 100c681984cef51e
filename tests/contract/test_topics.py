"""Topics and services: later turns, history, QoS that must match, no answer, the graph."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rcl_interfaces.msg import Log
from rclpy.action import ActionClient, get_action_client_names_and_types_by_node
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)
from std_msgs.msg import Int32, String
from std_srvs.srv import Empty, SetBool, Trigger

from tests.support.ros import Ros
from tests.support.waiting import wait_until

LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=3, reliability=ReliabilityPolicy.BEST_EFFORT)


def test_nothing_is_delivered_inside_publish(ros: Ros) -> None:
    node = ros.node()
    events: list[str] = []
    publisher = node.create_publisher(Int32, "chain", 10)

    def on_message(message: Int32) -> None:
        events.append(f"begin {message.data}")
        if message.data < 2:
            publisher.publish(Int32(data=message.data + 1))
        events.append(f"end {message.data}")

    node.create_subscription(Int32, "chain", on_message, 10)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    publisher.publish(Int32(data=0))
    wait_until(lambda: events and events[-1] == "end 2")
    assert events == ["begin 0", "end 0", "begin 1", "end 1", "begin 2", "end 2"]


@pytest.mark.parametrize("depth", [1, 3])
def test_an_unspun_subscription_keeps_the_last_depth_messages(ros: Ros, depth: int) -> None:
    node = ros.node()
    publisher, received = ros.topic(Int32, node, qos=depth)
    for number in range(10):
        publisher.publish(Int32(data=number))
    ros.spin(node)
    wait_until(lambda: received and received[-1].data == 9)
    assert [message.data for message in received] == [*range(10 - depth, 10)]


def test_a_transient_local_publisher_serves_late_joiners_that_ask(ros: Ros) -> None:
    late: list[int] = []
    volatile: list[int] = []
    node = ros.node()
    publisher = node.create_publisher(Int32, "topic", LATCHED)
    for number in range(5):
        publisher.publish(Int32(data=number))
    node.create_subscription(Int32, "topic", lambda m: late.append(m.data), LATCHED)
    node.create_subscription(Int32, "topic", lambda m: volatile.append(m.data), 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    ros.spin(node)
    wait_until(lambda: len(late) == 3)
    publisher.publish(Int32(data=5))
    wait_until(lambda: late[-1] == 5 and volatile)
    assert late == [2, 3, 4, 5]
    assert volatile == [5]


def test_incompatible_qos_does_not_connect_and_says_so(ros: Ros) -> None:
    received: list[Int32] = []
    logs: list[str] = []
    listener = ros.node("listener")
    listener.create_subscription(Log, "/rosout", lambda m: logs.append(m.msg), 100)
    node = ros.node("node")
    ros.spin(listener, node)
    publisher = node.create_publisher(Int32, "topic", 10)
    node.create_subscription(Int32, "topic", received.append, LATCHED)
    wait_until(lambda: any("incompatible QoS" in x and "DURABILITY" in x for x in logs))
    publisher.publish(Int32(data=1))
    assert publisher.get_subscription_count() == 0
    assert received == []


def test_a_destroyed_subscription_gets_nothing(ros: Ros) -> None:
    node = ros.node()
    publisher, received = ros.topic(Int32, node)
    gone = node.create_subscription(Int32, "topic", received.append, 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    assert node.destroy_subscription(gone)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    for number in (1, 2):
        publisher.publish(Int32(data=number))
    wait_until(lambda: received and received[-1].data == 2)
    assert [message.data for message in received] == [1, 2]


RELIABLE = QoSProfile(depth=1)
SECOND, TWO_SECONDS = Duration(seconds=1), Duration(seconds=2)


def test_both_ends_are_told_which_policy_a_subscription_asks_too_much_of(ros: Ros) -> None:
    node = ros.node()
    told: dict[str, str] = {}
    publishers_told: dict[str, str] = {}
    manual = LivelinessPolicy.MANUAL_BY_TOPIC
    cases: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
        ("RELIABILITY", {"reliability": ReliabilityPolicy.BEST_EFFORT}, {}),
        ("DURABILITY", {}, {"durability": DurabilityPolicy.TRANSIENT_LOCAL}),
        ("DEADLINE", {"deadline": TWO_SECONDS}, {"deadline": SECOND}),
        ("LIVELINESS", {"liveliness": LivelinessPolicy.AUTOMATIC}, {"liveliness": manual}),
        ("", {"durability": DurabilityPolicy.TRANSIENT_LOCAL}, {}),
        ("", {"deadline": SECOND}, {"deadline": TWO_SECONDS}),
        ("", {"liveliness": manual, "liveliness_lease_duration": SECOND}, {"liveliness": manual}),
    ]

    def refused(told: dict[str, str], topic: str, event: Any) -> None:
        told[topic] = QoSPolicyKind(event.last_policy_kind).name

    for number, (policy, offered, requested) in enumerate(cases):
        topic = f"topic_{number}"
        offers, asks = QoSProfile(depth=1, **offered), QoSProfile(depth=1, **requested)
        ours = PublisherEventCallbacks(incompatible_qos=partial(refused, publishers_told, topic))
        theirs = SubscriptionEventCallbacks(incompatible_qos=partial(refused, told, topic))
        publisher = node.create_publisher(String, topic, offers, event_callbacks=ours)
        node.create_subscription(String, topic, print, asks, event_callbacks=theirs)
        if not policy:
            wait_until(lambda p=publisher: p.get_subscription_count() == 1)  # type: ignore[misc]
    ros.spin(node)
    refusals = {f"topic_{n}": policy for n, (policy, *_) in enumerate(cases) if policy}
    wait_until(lambda: told == publishers_told == refusals)


def test_a_callback_of_two_arguments_gets_the_messages_info(ros: Ros) -> None:
    node = ros.node()
    heard: list[tuple[str, Any]] = []
    node.create_subscription(String, "words", lambda m, info: heard.append((m.data, info)), 10)
    publisher = node.create_publisher(String, "words", 10)
    wait_until(lambda: publisher.get_subscription_count() == 1)
    ros.spin(node)
    for word in ("one", "two"):
        publisher.publish(String(data=word))
    wait_until(lambda: len(heard) == 2)
    assert [(word, info["publication_sequence_number"]) for word, info in heard] == [
        ("one", 1),
        ("two", 2),
    ]
    assert heard[0][1]["received_timestamp"] >= heard[0][1]["source_timestamp"] > 0


def test_discovery_tells_of_an_endpoint_what_dds_knows(ros: Ros) -> None:
    node = ros.node("talker", namespace="/lab")
    publisher = node.create_publisher(
        String, "words", QoSProfile(depth=7, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    wait_until(lambda: node.count_publishers("words") == 1)
    info = node.get_publishers_info_by_topic("words")[0]
    assert (info.node_name, info.node_namespace) == ("talker", "/lab")
    assert info.topic_type == "std_msgs/msg/String"
    assert (int(info.endpoint_type), len(info.endpoint_gid)) == (1, 16)
    qos = info.qos_profile
    assert (qos.history, qos.depth) == (HistoryPolicy.UNKNOWN, 0)
    assert (qos.reliability, qos.durability) == (
        ReliabilityPolicy.RELIABLE,
        DurabilityPolicy.TRANSIENT_LOCAL,
    )
    assert (str(qos.deadline), qos.liveliness) == ("Infinite", LivelinessPolicy.AUTOMATIC)
    assert publisher.logger_name == "lab.talker"
    assert publisher.wait_for_all_acked(Duration(seconds=1))
    publisher.assert_liveliness()


def test_clients_of_services_and_actions_are_listed_by_node(ros: Ros) -> None:
    node = ros.node("talker", namespace="/lab")
    node.create_client(Empty, "wipe")
    ActionClient(node, MoveToShelf, "move")
    wait_until(lambda: len(node.get_client_names_and_types_by_node("talker", "/lab")) >= 1)
    services = dict(node.get_client_names_and_types_by_node("talker", "/lab"))
    assert services["/lab/wipe"] == ["std_srvs/srv/Empty"]
    wait_until(lambda: get_action_client_names_and_types_by_node(node, "talker", "/lab"))
    actions = get_action_client_names_and_types_by_node(node, "talker", "/lab")
    assert actions == [("/lab/move", ["archo_interfaces/action/MoveToShelf"])]


def test_a_call_is_answered(ros: Ros) -> None:
    def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success, response.message = request.data, "done"
        return response

    server = ros.spun("server")
    server.create_service(SetBool, "set", answer)
    client = ros.spun("client").create_client(SetBool, "set")
    assert client.wait_for_service(10.0)
    response = ros.result(client.call_async(SetBool.Request(data=True)))
    assert (response.success, response.message) == (True, "done")
    assert client.call(SetBool.Request(data=False)).success is False


def test_an_async_callback_is_awaited(ros: Ros) -> None:
    server = ros.spun("server")
    other = server.create_client(Trigger, "inner")

    async def outer(request: Any, response: Any) -> Any:
        response.message = "outer"
        return response

    server.create_service(Trigger, "outer", outer)
    client = ros.spun("client").create_client(Trigger, "outer")
    assert client.wait_for_service(10.0)
    assert not other.service_is_ready()
    assert ros.result(client.call_async(Trigger.Request())).message == "outer"


def test_a_call_that_nobody_serves_stays_pending(ros: Ros) -> None:
    client = ros.spun().create_client(Trigger, "nobody")
    assert not client.wait_for_service(0.05)
    assert not client.service_is_ready()
    future = client.call_async(Trigger.Request())
    assert not future.done()
    client.remove_pending_request(future)


def test_a_service_comes_and_goes(ros: Ros) -> None:
    server = ros.spun("server")
    service = server.create_service(Trigger, "trigger", lambda request, response: response)
    client = ros.spun("client").create_client(Trigger, "trigger")
    assert client.wait_for_service(10.0)
    executor = server.executor
    assert executor is not None
    executor.create_task(server.destroy_service, service)  # on the thread that spins it
    wait_until(lambda: not client.service_is_ready())
