"""Actions: three services and two topics under `<name>/_action/`, as in ROS 2.

On the graph, every topic `<name>/_action/feedback` is one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.action.client import ActionClient as ActionClient
from rclpy.action.server import ActionServer as ActionServer
from rclpy.action.server import CancelResponse as CancelResponse
from rclpy.action.server import GoalResponse as GoalResponse

if TYPE_CHECKING:
    from rclpy.node import NamesAndTypes, Node

_SUFFIX = "/_action/feedback"
_TYPE_SUFFIX = "_FeedbackMessage"


def get_action_names_and_types(node: Node) -> NamesAndTypes:
    """Return every action that has a server or a client, sorted, with its types."""
    return _actions(node.get_topic_names_and_types())


def get_action_server_names_and_types_by_node(
    node: Node, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions that a node serves, sorted, with their types."""
    return _actions(
        node.get_publisher_names_and_types_by_node(remote_node_name, remote_node_namespace)
    )


def get_action_client_names_and_types_by_node(
    node: Node, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions of which a node is a client, sorted, with their types."""
    return _actions(
        node.get_subscriber_names_and_types_by_node(remote_node_name, remote_node_namespace)
    )


def _actions(topics: NamesAndTypes) -> NamesAndTypes:
    return [
        (name.removesuffix(_SUFFIX), [kind.removesuffix(_TYPE_SUFFIX) for kind in types])
        for name, types in topics
        if name.endswith(_SUFFIX)
    ]
