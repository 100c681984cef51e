"""More than anybody can read: keys answer, memory is bounded, digits stay right."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from rcl_interfaces.msg import Log
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from archo_tui.robot.state.events import LIMIT
from tests.support import chosen
from tests.support.console import FAST, Console, console

pytestmark = pytest.mark.real_time  # the floods come from threads of their own


@contextmanager
def flooding(op: Console, rate: float, publish: Callable[[int], None]) -> Iterator[list[int]]:
    """Call `publish` that often (Hz), or as often as the machine can, from a thread."""
    ending, sent = threading.Event(), [0]

    def run() -> None:
        began = time.monotonic()
        while not ending.is_set():
            due = int((time.monotonic() - began) * rate)
            for _ in range(min(due - sent[0], 100)):
                publish(sent[0])
                sent[0] += 1
            ending.wait(0.001)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield sent
    finally:
        ending.set()
        thread.join(10)


# On a busy machine this takes long, and an empty battery would refuse the move.
FULL = ("-p", "drain_min:=0.0", "-p", "drain_max:=0.0")


async def keys_answer(op: Console) -> None:
    """The main job by keys, while all that goes on."""
    op.send("r")
    said = "reset encoder: Encoder reset to zero"  # the list may show newer lines only
    await op.until(lambda: any(said == e.text for e in op.app.view.snapshot.events))
    op.send("g", "7", "enter")
    await op.until("Arrived at shelf 7")
    op.send("escape", "ctrl+x")
    await op.until(lambda: op.app.view.snapshot.motion.stopped)


async def test_ten_thousand_log_lines_a_second() -> None:
    async with console(*FAST, *FULL) as op:
        talker = Node("talker", context=op.session.context)
        publisher = talker.create_publisher(Log, "/rosout", 1000)

        def publish(number: int) -> None:
            text = f"{'abcdefghijk'[number % 11] * 5} \x1b[31m\u202e{number}"
            publisher.publish(Log(level=Log.WARN, name="talker", msg=text))

        with flooding(op, 10_000, publish) as sent:
            await op.until(lambda: sent[0] > 5_000)
            await keys_answer(op)
        assert len(op.app.view.snapshot.events) <= LIMIT
        assert "\x1b" not in op.text
        assert "\u202e" not in op.text
        assert "�[31m" in op.text
        talker.destroy_node()


@pytest.mark.night
async def test_dozens_of_nodes_with_twenty_parameters_each() -> None:
    count = 250 if chosen.ENGINE == "embedded" else 20  # DDS takes a second for each
    async with console(*FAST) as op:
        context = op.session.context
        executor = SingleThreadedExecutor(context=context)
        nodes = []
        for number in range(count):
            values: list[Parameter[float]] = [
                Parameter(f"gain_{n}", value=float(n)) for n in range(20)
            ]
            node = Node(
                f"guest_{number:03}",
                context=context,
                parameter_overrides=values,
                automatically_declare_parameters_from_overrides=True,
            )
            nodes.append(node)
            executor.add_node(node)
        ending = threading.Event()

        def spin() -> None:
            try:
                while not ending.is_set():
                    executor.spin_once(0.1)
            except ExternalShutdownException:
                pass

        thread = threading.Thread(target=spin, daemon=True)
        thread.start()
        try:
            await op.until(lambda: len(op.app.view.snapshot.parameters) > count * 20, 60)
            await keys_answer(op)
            await op.press("4", "end")
            await op.until(lambda: "max_speed" in op.text)
            await op.press("slash")
            await op.type("guest_007")
            await op.until(
                lambda: "guest_007 gain" in op.words and "guest_008 gain" not in op.words
            )
        finally:
            ending.set()
            thread.join(10)
            executor.shutdown(0)
            for node in nodes:
                node.destroy_node()
