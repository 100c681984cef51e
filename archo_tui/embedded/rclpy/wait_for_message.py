"""`rclpy.wait_for_message`."""

from __future__ import annotations

import threading
from typing import Any

from rclpy import _time_source
from rclpy.node import Node
from rclpy.qos import QoSProfile


def wait_for_message(
    msg_type: Any,
    node: Node,
    topic: str,
    *,
    qos_profile: QoSProfile | int = 1,
    time_to_wait: float = -1,
) -> tuple[bool, Any]:
    """`(True, message)` for the next message, `(False, None)` after `time_to_wait` (s)."""
    came = threading.Condition()

    def wake() -> None:
        with came:
            came.notify_all()

    subscription = node.create_subscription(msg_type, topic, lambda _: None, qos_profile)
    subscription._notify = wake  # type: ignore[method-assign]  # not the executor: it is taken here
    try:
        with came:
            _time_source.wait_until(
                came,
                lambda: subscription._waiting() > 0 or not node.context.ok(),
                _time_source.deadline_ns(time_to_wait),
            )
        if subscription._waiting():
            return True, subscription._queue.popleft()
        return False, None
    finally:
        node.destroy_subscription(subscription)
