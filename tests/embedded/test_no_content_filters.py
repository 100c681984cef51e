"""A content filter has no effect here, as with an RMW that has none; and that can be seen."""

from __future__ import annotations

import pytest
from rclpy._rclpy_pybind11 import RCLError
from std_msgs.msg import Int32

from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="Fast DDS filters")
def test_all_messages_arrive_whatever_the_filter(ros: Ros) -> None:
    from rclpy.subscription_content_filter_options import ContentFilterOptions  # Jazzy has none

    node, heard = ros.node(), list[int]()
    subscription = node.create_subscription(
        Int32,
        "things",
        lambda message: heard.append(message.data),
        10,
        content_filter_options=ContentFilterOptions("data > %0", ["15"]),
    )
    assert not subscription.is_cft_enabled
    with pytest.raises(RCLError, match="Failed to set cft expression parameters"):
        subscription.set_content_filter("data > 15", [])
    publisher = node.create_publisher(Int32, "things", 10)
    for value in (10, 20):
        publisher.publish(Int32(data=value))
    ros.spin(node)
    wait_until(lambda: heard == [10, 20])
