"""The size of a message as CDR is that of its fields, whatever the engine hands out behind them."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest

pytest.importorskip("depot_interfaces")

from archo_interfaces.srv import EmergencyStop
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Int16MultiArray, String

from archo_tui.robot.node import cdr_size
from tests.support import chosen


def parameter(random: Random) -> Parameter:
    value = ParameterValue(
        type=random.randrange(10),
        string_value="ü" * random.randrange(9),
        byte_array_value=[bytes([n]) for n in range(random.randrange(4))],
        double_array_value=[0.5] * random.randrange(4),
        bool_array_value=[True] * random.randrange(4),
        string_array_value=["x" * random.randrange(5) for _ in range(random.randrange(4))],
    )
    return Parameter(name="n" * random.randrange(9), value=value)


def messages() -> list[Any]:
    random = Random(3)
    events = [
        ParameterEvent(
            node="/" + "x" * random.randrange(9),
            new_parameters=[parameter(random) for _ in range(random.randrange(4))],
            deleted_parameters=[parameter(random) for _ in range(random.randrange(2))],
        )
        for _ in range(200)
    ]
    return [*events, EmergencyStop.Request(), String(data="a"), Int16MultiArray(data=[1, 2, 3])]


def test_all_that_is_cut_off_is_behind_the_message() -> None:
    for message in messages():
        data, size = serialize_message(message), cdr_size(message)
        assert size <= len(data)
        assert deserialize_message(data[:size], type(message)) == message
        if chosen.ENGINE == "embedded":
            assert size == len(data)
