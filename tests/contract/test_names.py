"""Rule 7: names are validated, expanded and remapped; arguments behind --ros-args."""

from __future__ import annotations

from pathlib import Path

import pytest
import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.context import Context
from rclpy.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NotInitializedException,
)
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_default_context
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from tests.support.ros import Ros


def test_names_expand_from_namespace_and_node(ros: Ros) -> None:
    node = ros.node("node", namespace="/ns")
    assert node.get_fully_qualified_name() == "/ns/node"
    assert node.create_publisher(Float32, "topic", 10).topic_name == "/ns/topic"
    assert node.create_publisher(Float32, "~/topic", 10).topic_name == "/ns/node/topic"
    assert node.create_publisher(Float32, "/topic", 10).topic_name == "/topic"
    assert node.create_client(Trigger, "~/srv").service_name == "/ns/node/srv"
    assert ros.node("other", namespace="bare").get_namespace() == "/bare"


@pytest.mark.parametrize("name", ["", "with space", "1st", "end/", "a~b", "dash-ed", "a{b", "a{x}"])
def test_a_bad_name_is_an_error_of_its_kind_wherever_it_is_given(name: str, ros: Ros) -> None:
    node = ros.node()
    with pytest.raises((InvalidTopicNameException, ValueError)):
        node.create_publisher(Float32, name, 10)
    with pytest.raises((InvalidServiceNameException, ValueError)):
        node.create_client(Trigger, name)
    for count in (node.count_publishers, node.count_subscribers, node.count_services):
        with pytest.raises(ValueError):
            count(name)
    with pytest.raises(ValueError):
        node.get_publishers_info_by_topic(name)
    for resolve in (node.resolve_topic_name, node.resolve_service_name):
        with pytest.raises(RCLError):
            resolve(name)


@pytest.mark.parametrize(
    ("name", "namespace"),
    [(name, "/") for name in ("", "1st", "with space", "a/b", "dash-ed", "x" * 256)]
    + [("node", namespace) for namespace in ("/a//b", "/1st", "/end/", "/dash-ed")],
)
def test_bad_names_of_nodes_and_namespaces_are_refused(ros: Ros, name: str, namespace: str) -> None:
    with pytest.raises((InvalidNodeNameException, InvalidNamespaceException, ValueError)):
        ros.node(name, namespace=namespace)


def test_a_node_needs_an_initialised_context() -> None:
    with pytest.raises(NotInitializedException):
        Node("node", context=Context())


def test_init_twice_and_shutdown_twice_are_errors() -> None:
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    with pytest.raises(RuntimeError):
        rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    rclpy.shutdown(context=context)
    with pytest.raises(RuntimeError):
        rclpy.shutdown(context=context)
    rclpy.try_shutdown(context=context)
    assert not context.ok()


def test_remapping_renames_topics_services_nodes_and_namespaces() -> None:
    words = ["-r", "topic:=other", "-r", "one:srv:=/moved", "-r", "__ns:=/robot", "-r"]
    with Ros([*words, "two:__node:=deux"]) as graph:
        one = graph.node("one")
        assert one.get_fully_qualified_name() == "/robot/one"
        assert one.create_publisher(Float32, "topic", 10).topic_name == "/robot/other"
        assert one.create_client(Trigger, "srv").service_name == "/moved"
        two = graph.node("two")
        assert two.get_name() == "deux"
        assert two.create_client(Trigger, "srv").service_name == "/robot/srv"


def test_a_nodes_own_rule_wins_over_everybodys() -> None:
    with Ros(["-r", "topic:=everybodys"]) as graph:
        node = graph.node("node", cli_args=["--ros-args", "-r", "topic:=mine"])
        assert node.create_publisher(Float32, "topic", 10).topic_name == "/mine"
        other = graph.node("other")
        assert other.create_publisher(Float32, "topic", 10).topic_name == "/everybodys"


def test_parameters_on_the_command_line_override_declared_values() -> None:
    with Ros(
        ["-p", "everywhere:=1.5", "-p", "one:only:=text", "-p", "flags:=[true, false]"]
    ) as graph:
        one, two = graph.node("one"), graph.node("two")
        for node in (one, two):
            node.declare_parameter("everywhere", 0.5)
            node.declare_parameter("only", "default")
        one.declare_parameter("flags", [False])
        assert one.get_parameter("everywhere").value == 1.5
        assert two.get_parameter("everywhere").value == 1.5
        assert one.get_parameter("only").value == "text"
        assert two.get_parameter("only").value == "default"
        assert list(one.get_parameter("flags").value) == [True, False]
        one.declare_parameter("other", 3)
        assert one.get_parameter("other").value == 3


PARAMETERS = """\
/**:
  ros__parameters:
    common: 1.0
    kind: everybody's
node:
  ros__parameters:
    kind: node's
    nested:
      integer: 0x10
      exponent: 1e3
      word: on
      text: "1"
/ns/node:
  ros__parameters:
    kind: another's
    common: [1.0, 2.5]
"""


def test_parameter_files_type_their_values(tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text(PARAMETERS)
    later = tmp_path / "later.yaml"
    later.write_text("node:\n  ros__parameters:\n    common: 3.0\n")
    with Ros(["--params-file", str(file), "--params-file", str(later)]) as graph:
        node = graph.node("node")
        values = {
            "common": 0.0,
            "kind": "",
            "nested.integer": 0,
            "nested.exponent": 0.0,
            "nested.word": False,
            "nested.text": "",
        }
        for name, value in values.items():
            node.declare_parameter(name, value)
        assert {name: node.get_parameter(name).value for name in values} == {
            "common": 3.0,
            "kind": "node's",
            "nested.integer": 16,
            "nested.exponent": 1000.0,
            "nested.word": True,
            "nested.text": "1",
        }
        other = graph.node("node", namespace="/ns")
        other.declare_parameter("common", [0.0])
        other.declare_parameter("kind", "")
        assert list(other.get_parameter("common").value) == [1.0, 2.5]
        assert other.get_parameter("kind").value == "another's"


@pytest.mark.parametrize(
    "text", ["a: [1, 2", "node:\n  max_speed: 1.0\n", "ros__parameters:\n  a: 1\n", "- 1\n- 2\n"]
)
def test_a_bad_parameter_file_is_an_error_of_init(tmp_path: Path, text: str) -> None:
    file = tmp_path / "params.yaml"
    file.write_text(text)
    with pytest.raises(Exception, match=r"params\.yaml|parameter|arguments"):
        Ros(["--params-file", str(file)])


@pytest.mark.parametrize(
    "words",
    [
        ["--no-such-option"],
        ["-p", "novalue"],
        ["-r"],
        ["-r", "__ns:=/dash-ed"],
        ["-r", "__node:=a/b"],
        ["--params-file", "/no/such"],
        *[["-r", rule] for rule in ("a b:=c", "a:=b c", "x?:=y", "/:=/b", "a")],
        *[["-p", f"x:={value}"] for value in ("", "&a", "*", "@", "{a: 1}", "[1, a]", "[1, 2.0]")],
    ],
)
def test_a_bad_argument_is_an_error_of_init_and_of_a_node(words: list[str], ros: Ros) -> None:
    error = RuntimeError if words == ["--no-such-option"] else RCLError
    with pytest.raises(error):
        Ros(words)
    with pytest.raises(error, match=r"Failed to parse ROS arguments|--no-such-option"):
        ros.node(cli_args=["--ros-args", *words])


def test_the_default_context_is_another_one_after_shutdown() -> None:
    for _ in range(2):
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        context = get_default_context()
        rclpy.shutdown()
        assert get_default_context() is not context
    with pytest.raises(RuntimeError):
        rclpy.shutdown()


@pytest.mark.parametrize(
    ("words", "value"),
    [
        ("-p x:=1 --params-file all.yaml", 2),
        ("--params-file all.yaml -p x:=1", 1),
        ("-p node:x:=1 --params-file all.yaml", 2),
        ("--params-file one.yaml -p x:=1", 1),
        ("-p x:=1 --params-file one.yaml", 3),
        ("-p x:=1 -p node:x:=2", 2),
        ("-p node:x:=2 -p x:=1 -p node:x:=4", 1),  # the nodes that were named later win
    ],
)
def test_of_two_values_for_a_parameter_the_order_decides(
    words: str, value: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros: Ros
) -> None:
    monkeypatch.chdir(tmp_path)
    for file, pattern, number in (("all.yaml", "/**", 2), ("one.yaml", "node", 3)):
        Path(file).write_text(f"{pattern}:\n  ros__parameters:\n    x: {number}\n")
    node = ros.node(cli_args=["--ros-args", *words.split()])
    assert node.declare_parameter("x", 0).value == value
