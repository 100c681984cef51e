"""What the engine leaves out of rclpy says so by name, and stands on the engine's page."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rcl_interfaces.msg import Log
from rclpy._rclpy_pybind11 import UnsupportedEventTypeError
from rclpy.action import ActionClient, ActionServer
from rclpy.clock import Clock
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from std_msgs.msg import Int32
from std_srvs.srv import SetBool

from archo_tui.embedded.absent import MODULES, NAMES
from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until

pytestmark = pytest.mark.skipif(chosen.ENGINE != "embedded", reason="it is there on ROS 2")
PAGE = Path(__file__).parent.parent.parent / "docs" / "embedded_engine.md"


def subscription(node: Node, **given: Any) -> Any:
    return node.create_subscription(Int32, "numbers", print, 10, **given)


@pytest.mark.parametrize("name", sorted(MODULES))
def test_a_module_that_is_left_out_is_named_where_it_is_imported(name: str) -> None:
    with pytest.raises(ImportError, match=f"no {name}: real ROS 2 has it"):
        importlib.import_module(name)
    assert f"`{name}`" in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("module", "name"), [(module, name) for module, names in NAMES.items() for name in names]
)
def test_a_name_that_is_left_out_is_named_where_it_is_imported(module: str, name: str) -> None:
    with pytest.raises(ImportError, match=rf"no {module}\.{name}: real ROS 2 has it"):
        exec(f"from {module} import {name}")
    assert f"`{name}`" in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("rclpy", "Parameter"),
        ("rclpy.node", "SetParametersResult"),
        ("rclpy.node", "ParameterMsg"),
        ("rclpy.node", "get_logger"),
        ("rclpy.executors", "Client"),
    ],
)
def test_a_name_that_a_module_only_imports_can_be_imported_from_there(
    module: str, name: str
) -> None:
    found: dict[str, Any] = {}
    exec(f"from {module} import {name}", found)
    assert found[name].__name__ == name.removesuffix("Msg")


def test_what_is_left_out_is_named_where_another_module_imports_it() -> None:
    with pytest.raises(ImportError, match=r"no rclpy\.waitable: real ROS 2 has it"):
        exec("from rclpy.node import Waitable")


def test_a_misspelt_name_is_python_s_own_error() -> None:
    with pytest.raises(ImportError, match="cannot import name 'QoSProfil'"):
        exec("from rclpy.qos import QoSProfil")
    assert not hasattr(Node, "create_guard_conditions")


def client(node: Node) -> Any:
    return node.create_client(SetBool, "switch")


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda node: node, "create_guard_condition"),
        (lambda node: node.get_clock(), "create_jump_callback"),
        (subscription, "set_content_filter"),
        (client, "configure_introspection"),
        (lambda node: ActionClient(node, MoveToShelf, "move"), "configure_introspection"),
        (lambda node: ActionServer(node, MoveToShelf, "move", print), "configure_introspection"),
        (lambda node: SetBool, "Event"),
        (lambda node: node.get_publishers_info_by_topic("/rosout")[0], "topic_type_hash"),
    ],
)
def test_an_attribute_that_is_left_out_is_named_where_it_is_used(
    make: Callable[[Node], object], name: str, ros: Ros
) -> None:
    thing = make(ros.node())
    with pytest.raises(AttributeError, match=f"no {name}: real ROS 2 has it"):
        getattr(thing, name)
    assert f"`{name}`" in PAGE.read_text(encoding="utf-8")


def test_what_is_left_out_is_not_there_for_who_asks_first(ros: Ros) -> None:
    node = ros.node()
    assert not hasattr(node, "create_guard_condition")
    assert not hasattr(Clock(), "create_jump_callback")


@pytest.mark.parametrize("name", ["content_filter_options", "qos_overriding_options"])
def test_an_argument_that_is_left_out_is_named_where_it_is_given(name: str, ros: Ros) -> None:
    node = ros.node()
    with pytest.raises(NotImplementedError, match=rf"create_subscription\({name}=\.\.\.\)"):
        subscription(node, **{name: object()})
    assert node.count_subscribers("numbers") == 0
    subscription(node, **{name: None})
    assert node.count_subscribers("numbers") == 1
    assert f"`{name}`" in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["deadline", "liveliness"])
def test_events_of_time_are_refused_as_by_a_middleware_that_has_none(name: str, ros: Ros) -> None:
    node = ros.node()
    given: dict[str, Any] = {name: print}
    with pytest.raises(UnsupportedEventTypeError, match=rf"SubscriptionEventCallbacks\({name}="):
        subscription(node, event_callbacks=SubscriptionEventCallbacks(**given))
    callbacks = PublisherEventCallbacks(**given)
    with pytest.raises(UnsupportedEventTypeError, match=rf"PublisherEventCallbacks\({name}="):
        node.create_publisher(Int32, "numbers", 10, event_callbacks=callbacks)
    assert node.count_subscribers("numbers") == node.count_publishers("numbers") == 0


def test_a_lone_surrogate_in_a_log_line_does_not_end_the_node(ros: Ros) -> None:
    lines: list[Any] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lines.append, 50, raw=True)
    node = ros.node("talker")
    assert node.get_logger().info("odd \udc80 name")
    wait_until(lambda: any("odd \ufffd name".encode() in line for line in [*lines]))
