"""What the engine leaves out of rclpy says so by name."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest
import rclpy.node
from rcl_interfaces.msg import Log
from rclpy.node import Node
from std_msgs.msg import String

from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until

pytestmark = pytest.mark.skipif(chosen.ENGINE != "embedded", reason="it is there on ROS 2")


def test_a_program_may_ask_first_whether_a_name_is_there() -> None:
    assert not hasattr(rclpy.node, "Waitable")
    assert not hasattr(Node, "create_guard_condition")
    with pytest.raises(AttributeError, match=r"no rclpy\.node\.Waitable: if real ROS 2 has it"):
        _ = rclpy.node.Waitable  # type: ignore[attr-defined]


def test_a_message_that_a_module_only_imports_need_not_have_been_used_before() -> None:
    code = (
        "from archo_tui.ros import engine\nengine.activate('embedded')\n"
        "from rclpy.node import FloatingPointRange, IntegerRange\nprint(IntegerRange())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "IntegerRange(" in done.stdout, done.stderr


def test_a_lone_surrogate_in_a_log_line_does_not_end_the_node(ros: Ros) -> None:
    lines: list[Any] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lines.append, 50, raw=True)
    node = ros.node("talker")
    assert node.get_logger().info("odd \udc80 name")
    wait_until(lambda: any("odd \ufffd name".encode() in line for line in [*lines]))


@pytest.mark.parametrize("name", ["content_filter_options", "qos_overriding_options"])
def test_an_argument_that_the_engine_lacks_is_refused_and_not_ignored(ros: Ros, name: str) -> None:
    given: Any = {name: object()}
    with pytest.raises(TypeError, match=name):
        ros.node().create_subscription(String, "topic", print, 10, **given)
