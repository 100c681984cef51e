"""Rules 5 and 8: timers, also of simulated time, callback groups, futures, tasks, coroutines."""

from __future__ import annotations

import contextlib
import threading
from typing import Any

import pytest
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.executors import (
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMsg
from std_msgs.msg import Int32

from tests.support.clock import pass_time, release, seconds, stuck
from tests.support.ros import Ros
from tests.support.waiting import wait_until


def test_a_timer_first_fires_after_one_period(ros: Ros) -> None:
    node = ros.node()
    ticks: list[float] = []
    start = seconds()
    node.create_timer(0.1, lambda: ticks.append(seconds() - start))
    ros.spin(node)
    wait_until(lambda: len(ticks) >= 2)
    assert ticks[0] >= 0.099
    assert ticks[1] >= 0.199


def test_a_slow_callback_skips_ticks(ros: Ros) -> None:
    node = ros.node()
    released = threading.Event()
    ticks: list[float] = []

    def tick() -> None:
        ticks.append(seconds())
        if len(ticks) == 1:
            with stuck():
                released.wait(30)

    node.create_timer(0.05, tick)
    ros.spin(node)
    wait_until(lambda: ticks)
    pass_time(0.3)  # six periods
    release(released)
    freed = seconds()
    pass_time(0.12)
    # queued ticks would be six at once; at most one late one and those of the time since
    assert sum(freed <= tick <= freed + 0.01 for tick in ticks) <= 2


def test_a_canceled_timer_rests_until_reset(ros: Ros) -> None:
    node = ros.node()
    ticks: list[int] = []
    timer = node.create_timer(0.01, lambda: ticks.append(1))
    timer.cancel()
    assert timer.is_canceled()
    other: list[int] = []
    node.create_timer(0.01, lambda: other.append(1))
    ros.spin(node)
    wait_until(lambda: len(other) >= 3)
    assert ticks == []
    timer.reset()
    wait_until(lambda: ticks)


@pytest.mark.parametrize(
    ("group", "at_once"),
    [(lambda: None, 1), (MutuallyExclusiveCallbackGroup, 1), (ReentrantCallbackGroup, 2)],
)
def test_only_a_reentrant_groups_callbacks_overlap(group: Any, at_once: int, ros: Ros) -> None:
    node, made = ros.node(), group()
    running, most = [0], [0]
    lock, ran = threading.Lock(), [0]
    both = threading.Barrier(2)

    def callback(message: Int32) -> None:
        with lock:
            running[0] += 1
            most[0] = max(most[0], running[0])
        with contextlib.suppress(threading.BrokenBarrierError):
            both.wait(0.2)
        with lock:
            running[0] -= 1
            ran[0] += 1

    for _ in range(2):
        node.create_subscription(Int32, "topic", callback, 10, callback_group=made)
    publisher = node.create_publisher(Int32, "topic", 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    ros.spin(node, executor=MultiThreadedExecutor(4, context=ros.context))
    publisher.publish(Int32())
    wait_until(lambda: ran[0] == 2)
    assert most[0] == at_once


@pytest.mark.parametrize("is_coroutine", [False, True])
def test_an_exception_leaves_spin_and_nobody_elses(ros: Ros, is_coroutine: bool) -> None:
    bad, good = ros.node("bad"), ros.node("good")
    ticks: list[int] = []

    def explode() -> None:
        raise ZeroDivisionError("boom")

    async def explode_later() -> None:
        explode()

    bad.create_timer(0.01, explode_later if is_coroutine else explode)
    good.create_timer(0.01, lambda: ticks.append(1))
    ros.spin(good)
    executor = ros.executor(bad)
    with pytest.raises(ZeroDivisionError, match="boom"):
        executor.spin()
    seen = len(ticks)
    wait_until(lambda: len(ticks) > seen)


@pytest.mark.parametrize(
    ("kind", "ends"),
    [(SingleThreadedExecutor, ["returned", "raised"]), (MultiThreadedExecutor, ["returned"])],
)
def test_shutting_the_context_down_ends_spin(kind: Any, ends: list[str], ros: Ros) -> None:
    executor = kind(context=ros.context)
    executor.add_node(ros.node())
    ended: list[str] = []

    def spin() -> None:
        try:
            executor.spin()
            ended.append("returned")
        except ExternalShutdownException:
            ended.append("raised")

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    ros.context.shutdown()
    thread.join(10)
    assert [end in ends for end in ended] == [True]
    executor.shutdown()


def test_spin_until_future_complete(ros: Ros) -> None:
    node = ros.node()
    future: Future[int] = Future()
    node.create_timer(0.01, lambda: future.set_result(7))
    executor = ros.executor(node)
    executor.spin_until_future_complete(future, 10)
    assert future.result() == 7
    never: Future[int] = Future()
    executor.spin_until_future_complete(never, 0.02)
    assert not never.done()


def test_a_task_returns_its_value_and_awaits_futures(ros: Ros) -> None:
    node = ros.node()
    executor = ros.spin(node)
    future: Future[str] = Future()

    async def wait(prefix: str) -> str:
        return prefix + await future

    task = executor.create_task(wait, "got ")
    plain = executor.create_task(lambda: 42)
    assert ros.result(plain) == 42
    assert not task.done()
    future.set_result("it")
    executor.wake()  # a waiting executor does not notice a future by itself
    assert ros.result(task) == "got it"


def test_a_future_has_one_of_three_ends() -> None:
    calls: list[Any] = []
    done: Future[int] = Future()
    done.add_done_callback(calls.append)
    done.set_result(1)
    done.add_done_callback(calls.append)
    assert calls == [done, done]
    assert (done.done(), done.cancelled(), done.result()) == (True, False, 1)

    failed: Future[int] = Future()
    failed.set_exception(ZeroDivisionError())
    assert failed.done()
    assert isinstance(failed.exception(), ZeroDivisionError)
    with pytest.raises(ZeroDivisionError):
        failed.result()

    cancelled: Future[int] = Future()
    cancelled.cancel()
    assert (cancelled.done(), cancelled.cancelled(), cancelled.result()) == (False, True, None)
    done.cancel()
    assert not done.cancelled()


def test_a_node_belongs_to_one_executor(ros: Ros) -> None:
    node = ros.node()
    first = SingleThreadedExecutor(context=ros.context)
    second = SingleThreadedExecutor(context=ros.context)
    assert first.add_node(node)
    assert not first.add_node(node)
    assert node.executor is first
    second.add_node(node)
    assert node.executor is second
    assert first.get_nodes() == []
    for executor in (first, second):
        executor.shutdown(0)


def test_what_is_queued_of_a_node_that_is_removed_is_not_run(ros: Ros) -> None:
    node, other = ros.node("removed"), ros.node("kept")
    ran: list[str] = []
    node.create_subscription(Int32, "topic", lambda _: ran.append("removed"), 10)
    other.create_subscription(Int32, "topic", lambda _: ran.append("kept"), 10)
    publisher = other.create_publisher(Int32, "topic", 10)
    wait_until(lambda: publisher.get_subscription_count() == 2)
    executor = ros.executor(node, other)
    publisher.publish(Int32())
    executor.remove_node(node)
    while not ran:
        executor.spin_once(1.0)
    executor.spin_once(0.05)
    assert ran == ["kept"]


class Alternating(Executor):
    """An executor of one's own: notes for which node it was asked, and does the work."""

    def __init__(self, *, context: Any) -> None:
        super().__init__(context=context)
        self.order: list[str] = []

    def spin_once(self, timeout_sec: float | None = None) -> None:
        task, entity, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
        self.order.append("a task" if node is None else node.get_name())
        assert entity is None or self.can_execute(entity) in (True, False)
        assert node is None or entity in list(node.subscriptions)
        task()


def test_an_executor_of_ones_own_is_handed_the_work(ros: Ros) -> None:
    node = ros.node()
    executor = Alternating(context=ros.context)
    executor.add_node(node)
    heard: list[int] = []
    node.create_subscription(Int32, "a", lambda m: heard.append(m.data), 10)
    node.create_publisher(Int32, "a", 10).publish(Int32(data=7))
    executor.create_task(lambda: None)
    while heard != [7]:
        executor.spin_once(10.0)
    assert set(executor.order) == {"a task", "node"}
    with pytest.raises(TimeoutException):
        executor.wait_for_ready_callbacks(timeout_sec=0.01)
    executor.shutdown()
    with pytest.raises(ShutdownException):
        executor.wait_for_ready_callbacks()


SIMULATED: Parameter[bool] = Parameter("use_sim_time", value=True)


class Simulation:
    """A node in simulated time, and the hand that moves the time."""

    def __init__(self, ros: Ros) -> None:
        self.node = ros.node("simulated", parameter_overrides=[SIMULATED])
        self.clock: Any = self.node.get_clock()
        self.executor = SingleThreadedExecutor(context=ros.context)
        self.executor.add_node(self.node)
        self._publisher = self.node.create_publisher(ClockMsg, "/clock", 1)
        wait_until(lambda: self._publisher.get_subscription_count() == 1)

    def at(self, seconds: float) -> bool:
        """It is that time now; everything that is due has been done."""
        message = ClockMsg()
        message.clock.sec, part = divmod(int(seconds * 1e9), 10**9)
        message.clock.nanosec = part
        self._publisher.publish(message)
        wanted = int(seconds * 1e9)
        wait_until(lambda: self.spin() or self.clock.now().nanoseconds == wanted)
        for _ in range(5):
            self.spin()
        return False

    def spin(self) -> bool:
        self.executor.spin_once(timeout_sec=0.01)
        return False


@pytest.fixture
def simulation(ros: Ros) -> Simulation:
    return Simulation(ros)


def test_without_a_clock_message_it_is_zero_and_ros_timers_stand_still(
    simulation: Simulation,
) -> None:
    ticks: list[str] = []
    node = simulation.node
    node.create_timer(0.01, lambda: ticks.append("ros"))
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    node.create_timer(0.01, lambda: ticks.append("steady"), clock=steady)
    wait_until(lambda: simulation.spin() or ticks.count("steady") >= 3)
    assert simulation.clock.ros_time_is_active
    assert simulation.clock.now() == Time(clock_type=ClockType.ROS_TIME)
    assert "ros" not in ticks


def test_timers_follow_the_clock_skip_what_was_missed_and_survive_a_jump_back(
    simulation: Simulation,
) -> None:
    ticks: list[float] = []
    now = simulation.clock.now
    timer = simulation.node.create_timer(1.0, lambda: ticks.append(now().nanoseconds / 1e9))
    for second in (0.5, 0.75, 1.0, 1.5, 3.75, 4.25):
        simulation.at(second)
    assert ticks == [1.0, 3.75, 4.25]
    assert timer.time_until_next_call() == 750_000_000
    simulation.at(2.0)
    assert timer.time_until_next_call() == 1_000_000_000
    for second in (2.5, 3.0):
        simulation.at(second)
    assert ticks == [1.0, 3.75, 4.25, 3.0]


def test_something_besides_a_bool_is_refused(ros: Ros) -> None:
    node: Node = ros.node()
    result = node.set_parameters([Parameter("use_sim_time", value=3)])[0]
    assert not result.successful
    assert not node.get_clock().ros_time_is_active
