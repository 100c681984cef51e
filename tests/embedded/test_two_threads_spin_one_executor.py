"""Two threads wait at one executor, for different times: whatever comes wakes who is to do it.

Here and not among the contracts: rclpy shares one generator between them, and may raise.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until

pytestmark = pytest.mark.skipif(chosen.ENGINE != "embedded", reason="the embedded executor's own")


@contextmanager
def thread(work: Callable[[], object]) -> Iterator[None]:
    """Somebody else who spins, until the end."""
    runs = threading.Thread(target=work, name="spin", daemon=True)
    runs.start()
    yield
    runs.join(30)
    assert not runs.is_alive(), "the other thread waits for ever"


def test_a_task_wakes_the_one_who_still_waits(ros: Ros) -> None:
    executor, done = SingleThreadedExecutor(context=ros.context), list[bool]()
    with thread(lambda: executor.spin_once(60.0)):
        executor.spin_once(0.1)  # in vain
        executor.create_task(done.append, True)
        wait_until(lambda: done, "the task", deadline=10)
    executor.shutdown()


def test_a_shutdown_ends_the_spin_that_still_waits(ros: Ros) -> None:
    executor, ended = SingleThreadedExecutor(context=ros.context), list[bool]()

    def spin() -> None:
        with pytest.raises(ExternalShutdownException):
            executor.spin_once(60.0)
        ended.append(True)

    with thread(spin):
        executor.spin_once(0.1)
        ros.context.try_shutdown()
        wait_until(lambda: ended, "the other spin to end", deadline=10)
    executor.shutdown()
