"""A subscription that wants some messages only."""

from __future__ import annotations

from typing import Any

import pytest
from rclpy._rclpy_pybind11 import InvalidHandle, RCLError
from rclpy.executors import SingleThreadedExecutor
from rclpy.subscription_content_filter_options import ContentFilterOptions
from std_msgs.msg import Bool, Float64, Header, Int32, Int32MultiArray, String, UInt64

from tests.support.ros import Ros
from tests.support.waiting import wait_until

Filter = str | tuple[str, ...]  # an expression, or one with its parameters


def options(given: Filter) -> ContentFilterOptions:
    expression, *parameters = (given,) if isinstance(given, str) else given
    return ContentFilterOptions(expression, parameters)


def check(ros: Ros, kind: Any, messages: list[Any], expected: dict[Filter, list[int]]) -> None:
    """Which messages pass each filter, by their numbers."""
    node, topic = ros.node(), f"of_{kind.__name__}"
    heard: dict[Filter, list[Any]] = {given: [] for given in expected}
    for given, its in heard.items():
        node.create_subscription(
            kind, topic, its.append, 100, content_filter_options=options(given)
        )
    all_heard: list[Any] = []
    node.create_subscription(kind, topic, all_heard.append, 100)
    publisher = node.create_publisher(kind, topic, 100)
    wait_until(lambda: publisher.get_subscription_count() == len(expected) + 1)
    for _ in range(2):  # the second time the first has been heard by all
        for message in messages:
            publisher.publish(message)
    ros.spin(node)
    wait_until(lambda: len(all_heard) == 2 * len(messages))
    passed = {given: 2 * numbers for given, numbers in expected.items()}

    def found() -> dict[Filter, list[int]]:
        return {given: [messages.index(one) for one in its] for given, its in heard.items()}

    wait_until(lambda: sum(map(len, heard.values())) >= sum(map(len, passed.values())))
    assert found() == passed


def test_numbers_are_compared_with_literals_and_parameters(ros: Ros) -> None:
    expected: dict[Filter, list[int]] = {
        ("data > %0", "15"): [1, 2],
        ("data >= %0 AND data < %1", "20", "30"): [1],
        "data = 10 or data = 30": [0, 2],
        "data = 10 OR data = 20 AND data = 30": [],  # from the left
        "data <> 20": [0, 2],
        "data != 20": [0, 2],
        "NOT data = 10": [1, 2],
        "not (data = 10 or data = 20)": [2],
        "data BETWEEN 15 AND 30": [1, 2],
        ("data NOT BETWEEN %0 and 25", "15"): [0, 2],
        "15 < data": [1, 2],
        "data > 15.5": [1, 2],
        "data>0x0F": [1, 2],
        "data > -5 AND data < +25": [0, 1],
        "data > 1e1": [1, 2],
        "data > data": [],
        "": [0, 1, 2],
    }
    check(ros, Int32, [Int32(data=value) for value in (10, 20, 30)], expected)


def test_real_numbers_large_ones_and_truth(ros: Ros) -> None:
    reals: dict[Filter, list[int]] = {"data > 1": [1, 2], ("data = %0", "2.5"): [2]}
    check(ros, Float64, [Float64(data=value) for value in (0.5, 1.5, 2.5)], reals)
    large: dict[Filter, list[int]] = {"data > 9223372036854775807": [1]}
    check(ros, UInt64, [UInt64(data=value) for value in (1, 2**63)], large)
    truth: dict[Filter, list[int]] = {
        ("data = %0", "TRUE"): [0],
        "data = false": [1],
        "data = 1": [0],
        "data <> TRUE": [1],
    }
    check(ros, Bool, [Bool(data=True), Bool(data=False)], truth)


def test_texts(ros: Ros) -> None:
    expected: dict[Filter, list[int]] = {
        ("data = %0", "'abc'"): [0],
        "data = `abc'": [0],
        "data > 'b'": [2, 3],
        "data BETWEEN 'a' AND 'b'": [0, 1],
        "data LIKE 'a%'": [0, 1],
        "data LIKE '_b_'": [0, 3],
        ("data like %0", "'%c'"): [0],
        "data MATCH '[a-b]+'": [1],
    }
    messages = [String(data=text) for text in ("abc", "ab", "bcd", "xbz", "")]
    check(ros, String, messages, expected)


def test_fields_of_fields_and_of_arrays(ros: Ros) -> None:
    headers = [Header(), Header(frame_id="map")]
    headers[1].stamp.sec = 20
    nested: dict[Filter, list[int]] = {
        "stamp.sec > 15": [1],
        "frame_id = '' AND stamp.sec < 1": [0],
    }
    check(ros, Header, headers, nested)
    arrays: dict[Filter, list[int]] = {
        "data[1] > 15": [1],
        "data[3] > 0": [],
        "layout.data_offset = 0": [0, 1],
    }
    check(ros, Int32MultiArray, [Int32MultiArray(data=[v, v]) for v in (10, 20)], arrays)


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        (Int32, "nothing > 1"),
        (Int32, "DATA > 1"),
        (Int32, "data"),
        (Int32, "data >"),
        (Int32, "data == 10"),
        (Int32, "data > 1 2"),
        (Int32, "data + 1 > 20"),
        (Int32, "data LIKE 20"),
        (Int32, "data > '5'"),
        (Int32, "data > %0"),
        (Int32, ("data > %0", "x")),
        (Int32, "5 < 6"),
        (Int32, "(data > 5"),
        (String, 'data = "abc"'),
        (String, "data NOT LIKE 'a'"),
        (String, ("data = %0", "abc")),
        (Header, "stamp > 1"),
        (Int32MultiArray, "data > 1"),
    ],
)
def test_what_is_no_filter_is_refused(ros: Ros, kind: Any, given: Filter) -> None:
    node = ros.node()
    with pytest.raises(RCLError, match="contentfilteredtopic"):
        node.create_subscription(
            kind, "things", lambda _: None, 10, content_filter_options=options(given)
        )


def test_a_filter_is_set_told_and_taken_away(ros: Ros) -> None:
    heard: list[int] = []
    node = ros.node()
    subscription = node.create_subscription(Int32, "things", lambda m: heard.append(m.data), 10)
    publisher = node.create_publisher(Int32, "things", 10)
    executor = SingleThreadedExecutor(context=ros.context)
    executor.add_node(node)

    def passing(*values: int) -> list[int]:
        """Spun only between two filters: a new one may make DDS's reader anew."""
        wait_until(lambda: publisher.get_subscription_count() == 1)
        heard.clear()
        for value in (*values, 100):  # the last one passes all
            publisher.publish(Int32(data=value))
        ros.spin_here(executor, lambda: 100 in heard)
        return heard[:-1]

    assert not subscription.is_cft_enabled
    with pytest.raises(RCLError, match="has not created a ContentFilteredTopic"):
        subscription.get_content_filter()
    subscription.set_content_filter("data > %0", ["15"])
    assert subscription.is_cft_enabled
    assert subscription.get_content_filter() == ContentFilterOptions("data > %0", ["15"])
    assert passing(10, 20) == [20]
    with pytest.raises(RCLError, match="failed to set_filter_expression"):
        subscription.set_content_filter("nothing > %0", ["5"])
    wrong: Any = 5
    with pytest.raises(TypeError):
        subscription.set_content_filter("data > %0", [wrong])
    assert passing(10, 20) == [20]
    subscription.set_content_filter("", [])
    assert not subscription.is_cft_enabled
    assert passing(10, 20) == [10, 20]
    node.destroy_subscription(subscription)
    with pytest.raises(InvalidHandle):
        subscription.set_content_filter("data > 1", [])
