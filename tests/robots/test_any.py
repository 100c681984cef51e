"""Any goal and any service, without a robot file: a form of its type."""

from __future__ import annotations

import random
from contextlib import AbstractAsyncContextManager
from functools import partial
from typing import Any

import pytest

pytest.importorskip("depot_interfaces")

from rclpy.node import Node
from textual.widgets import TextArea

from archo_tui.base.yaml_text.dump import block
from archo_tui.robot.messages.types import load_class as load_interface
from archo_tui.screen.message_form import MessageForm
from tests.robots.rover import Counting
from tests.support.console import Console, console, console_with
from tests.support.values import told, values_of


def counting() -> AbstractAsyncContextManager[tuple[Console, Counting]]:
    """The console with ARCHO's file, and a node that is not ARCHO's."""
    return console_with(Counting, "/fibonacci", "/inspect", "/plan")


async def form(op: Console, *keys: str) -> MessageForm:
    """Open the form of what is chosen by those keys."""
    await op.press(*keys)
    await op.until(lambda: isinstance(op.app.screen, MessageForm))
    await op.settle()
    assert isinstance(op.app.screen, MessageForm)
    return op.app.screen


async def test_fibonacci_is_sent_followed_and_cancelled_in_six_keys_beside_its_value() -> None:
    async with counting() as (op, _):
        await form(op, "G", "enter")
        assert "/fibonacci  depot_interfaces/action/Fibonacci" in op.text
        assert "order" in op.line("int32")
        await op.press("backspace", *"40", "enter")  # 8 s: it is still running when it is cancelled
        await op.until("RUNNING fibonacci 40")
        await op.until("so far   sequence [0, 1, 1, 2")
        await op.press("ctrl+c")
        await op.until("✗ CANCELLED")
        assert "sequence [0, 1, 1, 2" in op.line("✗ CANCELLED")
        await form(op, "G", *"fib", "enter")
        await op.press("backspace", "3", "enter")
        await op.until("✓ SUCCEEDED")
        assert "sequence [0, 1, 1, 2]" in op.line("✓ SUCCEEDED")
        await op.until("fibonacci 3 succeeded: sequence [0, 1, 1, 2]")
        await form(op, "G", *"fib", "enter")
        assert "order 3" in op.line("int32")
        await op.press("backspace", *"abc", "enter")
        await op.until("order: not a whole number: abc")
        await op.press(*["backspace"] * 3, *"99999999999", "enter")
        await op.until("order: at most 2147483647, not 99999999999")
        assert len(op.app.view.snapshot.history) == 2


async def test_what_is_typed_into_the_form_of_a_service_is_called_or_said() -> None:
    async with counting() as (op, node):
        await form(op, "C", *"plan", "enter")
        await op.until("enter next, then send   ↑ ↓ field   ^s send   esc cancel")
        await op.press("escape")
        await form(op, "G", *"fib", "enter")
        await op.until("enter send   esc cancel")
        await op.press("escape")
        await form(op, "C", *"plan", "enter")
        op.send(*"1.5", "enter", *"2.5", "enter", *"-3", *["enter"] * 3, "4", *["enter"] * 4)
        await op.press("enter")  # a held one stops at the last field
        await op.until(lambda: node.planned)
        start = node.planned[0].start
        assert (start.position.x, start.position.y, start.position.z) == (1.5, 2.5, -3.0)
        assert (start.orientation.z, start.orientation.w) == (4.0, 1.0)
        await op.until(lambda: not isinstance(op.app.screen, MessageForm))
        screen = await form(op, "C", *"plan", "enter")
        places = {field.path: number for number, field in enumerate(screen._message_fields)}
        for path, text, said in (
            ("waypoints", "[{q: 1}]", "there is no field waypoints[0].q: x, y, z"),
            ("waypoints", "[3]", "waypoints[0]: 3 is not the fields of depot_interfaces/Vector"),
            ("waypoints", "5", "waypoints: not a list: 5"),
            ("weights", "[a]", "weights: "),
        ):
            screen._fields[places["waypoints"]].value = "[]"
            screen._fields[places["weights"]].value = "[]"
            screen._fields[places["fast"]].value = "no"
            screen._fields[places[path]].value = text
            await op.press("ctrl+s")
            await op.until(said)
        assert len(node.planned) == 1
        typed = {"waypoints": "[{x: 1.0}, {y: 2}]", "weights": "[1, 2.5]", "fast": "yes"}
        for path, text in typed.items():
            screen._fields[places[path]].value = text
        await op.press("ctrl+s")
        await op.until("legs 2, route by the wall")
        request = node.planned[1]
        assert [(point.x, point.y) for point in request.waypoints] == [(1.0, 0.0), (0.0, 2.0)]
        assert (list(request.weights), request.fast) == ([1.0, 2.5], True)


async def test_a_goal_of_many_fields_is_one_yaml_text() -> None:
    async with counting() as (op, node):
        screen = await form(op, "G", *"inspect", "enter")
        area = screen.query_one(TextArea)
        assert "frame_id" in area.text
        area.text = "first: {pose: {position: {x: oops}}}"
        await op.press("ctrl+s")
        await op.until("first.pose.position.x: oops is not a number")
        area.text = "first: [1, 2"
        await op.press("ctrl+s")
        await op.until("line 1:")
        area.text = "first: {frame_id: map, pose: {position: {x: 2}}}\nlabels: [a, b]"
        await op.press("ctrl+s")
        await op.until("✓ SUCCEEDED")
        assert node.inspected[0].first.frame_id == "map"
        assert node.inspected[0].first.pose.position.x == 2.0
        assert node.inspected[0].second.pose.orientation.w == 1.0
        assert node.inspected[0].labels == ["a", "b"]


class Echoing(Node):
    """Answers with what it was asked, of every type there is."""

    def __init__(self, **options: Any) -> None:
        super().__init__("echoing", **options)
        self.asked: list[Any] = []
        self.create_service(load_interface("depot_interfaces/srv/Echo"), "echo", self._echo)

    def _echo(self, request: Any, response: Any) -> Any:
        self.asked.append(request)
        response.sample, response.more = request.sample, request.more
        return response


async def test_defaults_and_values_of_every_type_are_sent_and_received_unaltered() -> None:
    if load_interface("depot_interfaces/srv/Echo") is None:
        pytest.skip("depot_interfaces is an older one")
    async with console_with(Echoing, "/echo") as (op, node):
        screen = await form(op, "C", *"echo", "enter")
        chance, kind = random.Random(24), load_interface("depot_interfaces/srv/Echo").Request
        for values in (None, values_of(kind, chance), values_of(kind, chance)):
            if values is not None:  # else the text is sent as it was filled in
                screen.query_one(TextArea).text = block(values)
            await op.press("ctrl+s")
            await op.until(lambda: node.asked)
            assert told(node.asked.pop()) == told(values or kind())
            await op.until(lambda: not isinstance(op.app.screen, MessageForm))
            screen = await form(op, "C", *"echo", "enter")


async def test_where_nothing_is_offered_the_keys_say_so() -> None:
    async with console(node_makers=[partial(Node, "bare")], wait=False) as op:
        await op.press("G")
        await op.until("no action is on the graph")
        await op.press("C")
        await op.until("no service is on the graph")
