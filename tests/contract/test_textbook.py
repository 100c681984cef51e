"""The textbook's listings run unchanged in the default context; `tests/chapter` checks each."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from archo_interfaces.srv import ResetEncoder
from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Float32

from tests.contract.textbook import (
    battery_publisher,
    motor_parameters,
    reset_client,
)
from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until

DOMAIN = chosen.next_domain()  # of the listings, which use the default context


@pytest.fixture
def neighbour(monkeypatch: pytest.MonkeyPatch) -> Iterator[Ros]:
    """Nodes of the test's on the same domain, in a context of their own."""
    # two contexts of one process must see each other here, and nobody else's
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with Ros(domain_id=DOMAIN) as graph:
        yield graph


@contextlib.contextmanager
def listed(make: Callable[[], Node], *words: str) -> Iterator[Any]:
    """A listing's node, run as its main() does, but with a domain of the test's own."""
    rclpy.init(
        args=["--ros-args", "--disable-stdout-logs", *words],
        domain_id=DOMAIN,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    node = make()

    def run() -> None:
        try:
            with contextlib.suppress(ExternalShutdownException):
                rclpy.spin(node)
        except Exception as error:
            # shut down while a callback published, or just as rclpy builds its wait set
            is_over = isinstance(error, InvalidHandle) or "context is not valid" in str(error)
            if rclpy.ok() or not is_over:
                raise

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        yield node
    finally:
        rclpy.try_shutdown()
        thread.join(10)
        node.destroy_node()
    assert not thread.is_alive()


def test_the_publisher_counts_down(neighbour: Ros) -> None:
    heard: list[float] = []
    neighbour.spun("ear").create_subscription(
        Float32, "battery_level", lambda m: heard.append(m.data), 10
    )
    with listed(battery_publisher.BatteryPublisher):
        wait_until(lambda: len(heard) >= 3)
    assert heard[1] - heard[2] == 0.5


def test_the_client_spins_until_its_future_is_complete(
    neighbour: Ros, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = ResetEncoder.Response(success=True, message="done")
    node = neighbour.spun("motor_controller")
    node.create_service(ResetEncoder, "reset_encoder", lambda request, response: answer)
    monkeypatch.setenv("ROS_DOMAIN_ID", str(DOMAIN))
    response: Any = reset_client.main(  # type: ignore[no-untyped-call]
        ["--ros-args", "--disable-stdout-logs"]
    )
    assert response == answer


def test_the_parameters_come_from_the_textbooks_file(neighbour: Ros, tmp_path: Path) -> None:
    file = tmp_path / "motor_params.yaml"
    file.write_text(
        "motor_controller:\n  ros__parameters:\n    max_speed: 1.2\n    wheel_radius: 0.1\n"
    )
    with listed(motor_parameters.MotorController, "--params-file", str(file)) as node:
        assert node.get_parameter("max_speed").value == 1.2
        assert node.get_parameter("wheel_radius").value == 0.1
