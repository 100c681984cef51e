"""Rule 6 for parameters: declared, typed, ranged; the services and the events."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterEvent,
    SetParametersResult,
)
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter, get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from tests.support.ros import Ros
from tests.support.waiting import wait_until

SPEED = ParameterDescriptor(
    description="m/s",
    floating_point_range=[FloatingPointRange(from_value=0.05, to_value=2.0, step=0.0)],
)
SHELVES = ParameterDescriptor(
    integer_range=[IntegerRange(from_value=1, to_value=9, step=2)],
)


def declare(node: Node) -> None:
    node.declare_parameter("speed", 0.8, SPEED)
    node.declare_parameter("shelves", 3, SHELVES)
    node.declare_parameter("fixed", 1024, ParameterDescriptor(read_only=True))
    node.declare_parameter("motor.name", "left")
    node.declare_parameter("gains", [1.0, 2.0])


def test_a_declared_parameter_has_its_default_type_and_descriptor(ros: Ros) -> None:
    node = ros.node()
    declare(node)
    assert node.get_parameter("speed").value == 0.8
    assert node.get_parameter("speed").type_ == Parameter.Type.DOUBLE
    descriptor = node.describe_parameter("speed")
    assert (descriptor.name, descriptor.type, descriptor.description) == ("speed", 3, "m/s")
    assert descriptor.floating_point_range[0].to_value == 2.0
    assert node.has_parameter("use_sim_time")


DOUBLE = Parameter.Type.DOUBLE
SPEEDS: list[Parameter[int]] = [Parameter("nothing", value=1)]
MISUSES: list[tuple[Callable[[Any], object], type[Exception], str]] = [
    (lambda n: n.declare_parameter("speed", 1.0), ParameterAlreadyDeclaredException, ""),
    (lambda n: n.get_parameter("nothing"), ParameterNotDeclaredException, ""),
    (lambda n: n.set_parameters(SPEEDS), ParameterNotDeclaredException, ""),
    (lambda n: n.undeclare_parameter("fixed"), ParameterImmutableException, ""),
    (lambda n: n.declare_parameter("x", 9.0, SPEED), InvalidParameterValueException, ": x$"),
    (
        lambda n: [n.declare_parameter("x", DOUBLE), n.get_parameter("x")],
        ParameterUninitializedException,
        "",
    ),
    (lambda n: n.declare_parameter("x", None, ParameterDescriptor()), ValueError, ""),
    (lambda n: n.declare_parameter("x", Parameter.Type.NOT_SET), ValueError, ""),
    (
        lambda n: n.declare_parameters("", [("x", 1), ("speed", 2.0)]),
        ParameterAlreadyDeclaredException,
        "",
    ),
    (lambda n: n.add_on_set_parameters_callback(None), TypeError, "callable"),
    (lambda _: Parameter("x", Parameter.Type.BYTE_ARRAY, [b"two"]), ValueError, ""),
]


@pytest.mark.parametrize(("misuse", "error", "said"), MISUSES)
def test_misuse_raises_rclpys_exceptions(
    ros: Ros, misuse: Callable[[Any], object], error: type[Exception], said: str
) -> None:
    node = ros.node()
    declare(node)
    with pytest.raises(error, match=said or None):
        misuse(node)
    assert not node.has_parameter("x") or error is ParameterUninitializedException


def test_an_override_of_the_wrong_type_raises_in_declare() -> None:
    with Ros(["-p", "speed:=fast", "-p", "limit:=9.0", "-p", "whole:=2"]) as graph:
        node = graph.node()
        with pytest.raises(InvalidParameterTypeException, match=r": speed$"):
            node.declare_parameter("speed", 0.8)
        with pytest.raises(InvalidParameterValueException):
            node.declare_parameter("limit", 0.8, SPEED)
        with pytest.raises(InvalidParameterTypeException):
            node.declare_parameter("whole", 0.8)


@pytest.mark.parametrize(
    ("parameter", "reason"),
    [
        (Parameter("speed", value=1), "Wrong parameter type, expected 'Type.DOUBLE'"),
        (Parameter("speed", value="1.0"), "Wrong parameter type"),
        (Parameter("speed", value=2.1), "Parameter speed out of range"),
        (Parameter("speed", value=float("nan")), "Parameter speed out of range"),
        (Parameter("shelves", value=10), "Parameter shelves out of range"),
        (Parameter("shelves", value=4), "valid step"),
        (Parameter("fixed", value=1), "Trying to set a read-only parameter: fixed."),
        *[(Parameter("speed", value=value), "") for value in (0.05, 2.0, 1.234)],  # The edges.
    ],
)
def test_a_value_that_the_descriptor_forbids_is_refused(
    ros: Ros, parameter: Parameter[Any], reason: str
) -> None:
    node = ros.node()
    declare(node)
    before = node.get_parameter(parameter.name).value
    result = node.set_parameters([parameter])[0]
    assert result.successful is not bool(reason)
    assert reason.replace("Type.DOUBLE", "") in result.reason.replace("Type.DOUBLE", "").replace(
        "expected '3'", "expected ''"
    )
    assert node.get_parameter(parameter.name).value == (before if reason else parameter.value)


def test_callbacks_see_refuse_and_follow_a_change(ros: Ros) -> None:
    node = ros.node()
    declare(node)
    told: list[float] = []

    def refuse(parameters: list[Parameter[Any]]) -> SetParametersResult:
        if any(p.name == "speed" and p.value > 1.5 for p in parameters):
            return SetParametersResult(successful=False, reason="too fast today")
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(refuse)
    node.add_post_set_parameters_callback(
        lambda parameters: told.extend(p.value for p in parameters)
    )
    refused, taken = node.set_parameters(
        [Parameter("speed", value=1.9), Parameter("speed", value=1.1)]
    )
    assert (refused.successful, refused.reason) == (False, "too fast today")
    assert taken.successful
    assert told == [1.1]


def test_setting_atomically_changes_all_or_none(ros: Ros) -> None:
    node = ros.node()
    declare(node)
    both: list[Parameter[Any]] = [Parameter("speed", value=1.0), Parameter("shelves", value=99)]
    assert not node.set_parameters_atomically(both).successful
    assert node.get_parameter("speed").value == 0.8


def test_parameters_are_seen_and_set_from_another_node(ros: Ros) -> None:
    declare(ros.spun("server"))
    client = AsyncParameterClient(ros.spun("client"), "server")
    assert client.wait_for_services(10.0)
    names = ros.result(client.list_parameters()).result.names
    assert {"speed", "shelves", "fixed", "motor.name", "gains", "use_sim_time"} <= set(names)
    assert list(ros.result(client.list_parameters(["motor"], 10)).result.names) == ["motor.name"]
    values = ros.result(client.get_parameters(["speed", "gains"])).values
    assert values[0].double_value == 0.8
    assert list(values[1].double_array_value) == [1.0, 2.0]
    assert ros.result(client.get_parameters(["nothing"])).values == []
    described = ros.result(client.describe_parameters(["fixed"])).descriptors
    assert described[0].read_only
    results = ros.result(
        client.set_parameters([Parameter("speed", value=1.5), Parameter("nothing", value=1)])
    ).results
    assert results[0].successful
    assert "Invalid access to undeclared parameter(s)" in results[1].reason
    atomically = ros.result(client.set_parameters_atomically([Parameter("speed", value=9.0)]))
    assert not atomically.result.successful
    assert list(ros.result(client.get_parameter_types(["speed"])).types) == [3]


def test_every_change_is_an_event(ros: Ros) -> None:
    events: list[ParameterEvent] = []
    ros.spun("listener").create_subscription(ParameterEvent, "/parameter_events", events.append, 50)
    node = ros.spun("node", namespace="/ns")
    wait_until(lambda: node.count_subscribers("/parameter_events") == 1)
    node.declare_parameter("speed", 0.8)
    node.set_parameters([Parameter("speed", value=1.5)])

    def mine() -> list[ParameterEvent]:
        found = [*events]
        return [
            e
            for e in found
            if [p.name for p in (*e.new_parameters, *e.changed_parameters)] == ["speed"]
        ]

    wait_until(lambda: len(mine()) == 2)
    new, changed = mine()
    assert new.node == changed.node == "/ns/node"
    assert changed.changed_parameters[0].value.double_value == 1.5


@pytest.mark.pure
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("1", 1),
        ("0x10", 16),
        ("1.5", 1.5),
        (".inf", float("inf")),
        ("1e3", "1e3"),  # as PyYAML has it, other than rcl
        ("", ""),
        ("[1, 2]", [1, 2]),
        ("[1.0, 2]", "[1.0, 2]"),
        ("[a, b]", ["a", "b"]),
        ('"5"', "5"),
    ],
)
def test_a_text_is_a_value_as_on_a_command_line(text: str, value: Any) -> None:
    assert parameter_value_to_python(get_parameter_value(text)) == value


def test_what_every_callback_before_a_change_returns_is_set(ros: Ros) -> None:
    node = ros.node()
    node.declare_parameter("a", 1)
    node.declare_parameter("b", 1)
    seen: list[list[str]] = []

    def also_b(parameters: Any) -> Any:
        seen.append([parameter.name for parameter in parameters])
        return [Parameter("b", value=5)]

    node.add_pre_set_parameters_callback(also_b)
    node.add_pre_set_parameters_callback(lambda parameters: parameters)
    assert node.set_parameters([Parameter("a", value=2)])[0].successful
    assert seen == [["a"]]
    assert (node.get_parameter("a").value, node.get_parameter("b").value) == (2, 5)
    other = ros.node("other")
    other.declare_parameter("a", 1)
    other.add_pre_set_parameters_callback(lambda parameters: [])
    assert "cannot be empty" in other.set_parameters([Parameter("a", value=2)])[0].reason


def test_a_callback_that_answers_with_something_else_is_warned_of(ros: Ros) -> None:
    node = ros.node()
    node.declare_parameter("a", 1)
    node.add_on_set_parameters_callback(lambda parameters: None)  # type: ignore[arg-type,return-value]
    with pytest.warns(UserWarning, match="invalid type"):
        (result,) = node.set_parameters([Parameter("a", value=2)])
    assert (result.successful, result.reason) == (False, "Callback returned an invalid type")


def test_instead_of_a_parameter_without_a_value_there_is_the_alternative(ros: Ros) -> None:
    node = ros.node()
    alternative: Parameter[int] = Parameter("other", value=3)
    assert node.get_parameter_or("speed", alternative) is alternative  # not declared
    node.declare_parameter("speed", Parameter.Type.INTEGER)
    assert node.get_parameter_or("speed", alternative) is alternative
    assert node.get_parameter_or("speed").type_ == Parameter.Type.NOT_SET
    node.set_parameters([Parameter("speed", value=5)])
    assert node.get_parameter_or("speed", alternative).value == 5
