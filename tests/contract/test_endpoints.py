"""What an endpoint tells: message info, what discovery says."""

from __future__ import annotations

from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, get_action_client_names_and_types_by_node
from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPresetProfiles,
    QoSProfile,
    ReliabilityPolicy,
)
from std_msgs.msg import String
from std_srvs.srv import Empty

from tests.support.ros import Ros
from tests.support.waiting import wait_until


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


def test_profiles_by_their_short_names() -> None:
    assert QoSPresetProfiles.get_from_short_key("sensor_data").depth == 5
    assert QoSProfile(depth=3) == QoSProfile(depth=3)
    assert QoSProfile(depth=3) != QoSProfile(depth=4)


def test_a_policy_takes_no_word() -> None:
    given: Any = QoSProfile(depth=1)
    for name in ("lifespan", "deadline", "liveliness", "depth", "history"):
        with pytest.raises(AssertionError):
            setattr(given, name, "x")
