"""Subscriptions to topics that are recorded and not shown, as the robot file lists them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from archo_tui.errors import in_one_line
from archo_tui.robot.endpoints import fitting_qos
from archo_tui.robot.listener import Listener
from archo_tui.robot.messages.types import load_class
from archo_tui.robot_file import mismatch


class RecordedTopics:
    """The subscriptions to those of the listed topics that have a publisher. ROS thread only.

    They only bring the messages to the black box, which has those of every subscription of the
    node.
    """

    def __init__(self, node: Listener, topics: Sequence[str], warn: Callable[[str], None]) -> None:
        self._node, self._warn = node, warn
        self._missing = [node.resolve_topic_name(topic) for topic in topics]
        self._subscriptions: list[Any] = []
        self._warned: set[str] = set()

    def subscribe(self) -> None:
        """Subscribe to each topic that has a publisher by now, with the first publisher's type.

        A topic whose type is not installed is tried again at the next call; one that rclpy refuses
        is not. Subscriptions are never ended or changed.
        """
        for topic in list(self._missing):
            publishers = self._node.get_publishers_info_by_topic(topic)
            if not publishers:
                continue
            kind = publishers[0].topic_type
            message_class = load_class(kind)
            if message_class is None:
                self._warn_once(topic, mismatch.not_installed(topic, kind))
                continue
            self._missing.remove(topic)
            try:
                subscription = self._node.listen_quietly(
                    message_class, topic, lambda _: None, fitting_qos(publishers)
                )
            except Exception as error:  # Fast DDS allows one type of a topic in a process.
                reason = in_one_line(error)
                self._warn_once(topic, mismatch.not_subscribed(topic, kind, reason))
            else:
                self._subscriptions.append(subscription)

    def _warn_once(self, topic: str, text: str) -> None:
        if topic not in self._warned:
            self._warned.add(topic)
            self._warn(f"not recorded: {text}")
