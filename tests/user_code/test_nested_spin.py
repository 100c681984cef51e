"""A callback of a hosted node that spins: `rclpy.spin_until_future_complete(self, future)`."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from archo_tui.robot.outcome import Code
from archo_tui.session.session import Session
from tests.support.waiting import wait_until
from tests.user_code.support import running, texts, written

CALLER = """
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger


class Caller(Node):
    def __init__(self):
        super().__init__("caller")
        group = {group}
        self.create_service(Trigger, "ping", self.ping, callback_group=group)
        self.client = self.create_client(Trigger, "ping", callback_group=group)
        self.count = 0
        self.create_timer(0.1, self.tick)

    def ping(self, request, response):
        response.success = True
        return response

    def tick(self):
        self.count += 1
        self.get_logger().warning(f"tick {{self.count}} begins")
        future = self.client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self, future{given})
        self.get_logger().warning(f"tick {{self.count}} ends: {{future.result().success}}")


def main():
    rclpy.init()
    {spin}
"""
OTHER = "MutuallyExclusiveCallbackGroup()"
SPIN = "rclpy.spin(Caller())"
OWN_EXECUTORS = ("SingleThreadedExecutor()", "MultiThreadedExecutor()")


def hosting(
    group: str = OTHER, spin: str = SPIN, given: str = "", name: str = "caller"
) -> AbstractContextManager[Session]:
    text = CALLER.format(group=group, spin=spin, given=given).replace('"caller"', f'"{name}"')
    return running(written(f"{name}.py", text))


def times(session: Session, text: str) -> int:
    return sum(event.count for event in session.robot.snapshot.events if event.text == text)


def test_a_node_that_spins_in_a_callback_ticks_on(here: Path) -> None:
    with hosting() as session:
        wait_until(lambda: "tick 4 ends: True" in texts(session))


def test_with_an_executor_of_its_own_it_ends_and_the_line_is_said(here: Path) -> None:
    for number, executor in enumerate(OWN_EXECUTORS):
        name = f"caller_{number}"
        with hosting(spin=f"rclpy.spin(Caller(), {executor})", name=name) as session:
            wait_until(lambda: "tick 1 ends: True" in texts(session))
            (event,) = (e for e in session.robot.snapshot.events if "executor" in e.text)
            assert (event.level, event.source) == ("WARN", name)
            assert event.text == (
                f"{name}.py:26: takes {name} from the executor of main(), which calls "
                f"nothing of {name} any more: pass executor=self.executor, "
                "in: rclpy.spin_until_future_complete(self, future)"
            )
            # what an executor of threads waited for before may be called once more
            last = 2 if "Multi" in executor else 1
            assert f"tick {last + 1} begins" not in texts(session)
            assert event.count == 1


def test_given_the_executor_of_main_it_ticks_on(here: Path) -> None:
    spin = "rclpy.spin(Caller(), SingleThreadedExecutor())"
    with hosting(spin=spin, given=", executor=self.executor") as session:
        wait_until(lambda: "tick 4 ends: True" in texts(session))
        assert not [text for text in texts(session) if "of main()" in text]


@pytest.mark.real_time
def test_stopping_a_node_ends_the_spin_that_would_never_end(here: Path) -> None:
    """The answer comes to the callback group that the timer's callback holds."""
    for spin in (SPIN, *(f"rclpy.spin(Caller(), {executor})" for executor in OWN_EXECUTORS)):
        with hosting(group="None", spin=spin) as session:
            wait_until(lambda: "tick 1 begins" in texts(session))
            outcome = session.host.stop_node("/caller")
            assert outcome == (Code.DONE, "/caller stopped"), spin
            assert session.host.start_node("/caller").ok
            wait_until(lambda: times(session, "tick 1 begins") == 2)
            assert "tick 1 ends: True" not in texts(session)
