"""Which coroutines are awaited, and what becomes of tasks and futures that nobody wants."""

from __future__ import annotations

import asyncio
import functools
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

from tests.support.ros import Ros


@pytest.fixture
def forgotten() -> Iterator[Callable[[Any], Any]]:
    """Hands a coroutine on that nobody will await; Python is not to complain of it."""
    coroutines: list[Any] = []

    def forget(coroutine: Any) -> Any:
        coroutines.append(coroutine)
        return coroutine

    yield forget
    for coroutine in coroutines:
        coroutine.close()


@pytest.fixture
def executor(ros: Ros) -> Iterator[SingleThreadedExecutor]:
    made = SingleThreadedExecutor(context=ros.context)
    yield made
    made.shutdown()


def _telling(*distances: float) -> Callable[[Any], Any]:
    """An execute callback whose goals give this feedback in one go and succeed."""

    def execute(goal: Any) -> Any:
        for distance in distances:
            goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=distance))
        goal.succeed()
        return MoveToShelf.Result()

    return execute


def test_an_async_callback_is_awaited_and_a_coroutine_that_another_returns_is_not(
    ros: Ros, executor: SingleThreadedExecutor, forgotten: Callable[[Any], Any]
) -> None:
    node = ros.node()
    heard: list[str] = []

    async def hear(how: str, _: Any = None) -> None:
        heard.append(how)

    node.create_subscription(Int32, "a", functools.partial(hear, "partial"), 10)
    node.create_subscription(Int32, "a", lambda message: forgotten(hear("lambda")), 10)
    node.create_timer(0.01, functools.partial(hear, "timer"))
    node.create_timer(0.01, lambda: forgotten(hear("lambda of a timer")))
    node.create_publisher(Int32, "a", 10).publish(Int32())
    executor.add_node(node)
    while not {"partial", "timer"} <= set(heard):
        executor.spin_once(10.0)
    for _ in range(8):
        executor.spin_once(0.01)
    assert set(heard) == {"partial", "timer"}


def test_a_service_that_returns_a_coroutine_without_async_answers_with_an_error(
    ros: Ros, executor: SingleThreadedExecutor, forgotten: Callable[[Any], Any]
) -> None:
    async def answer(response: Any) -> Any:
        return response

    node = ros.node()
    node.create_service(Trigger, "t", lambda request, response: forgotten(answer(response)))
    future = node.create_client(Trigger, "t").call_async(Trigger.Request())
    executor.add_node(node)
    with pytest.raises(TypeError):
        executor.spin_until_future_complete(future, 10.0)


def test_feedback_is_awaited_by_an_async_callback(
    ros: Ros, executor: SingleThreadedExecutor
) -> None:
    heard: list[float] = []

    async def hear(message: Any) -> None:
        heard.append(message.feedback.distance_remaining)

    node = ros.node()
    executor.add_node(node)
    server = ActionServer(node, MoveToShelf, "move", _telling(3.0))
    client = ActionClient(node, MoveToShelf, "move")
    goal = client.send_goal_async(MoveToShelf.Goal(), feedback_callback=hear)
    executor.spin_until_future_complete(goal, 10.0)
    while not heard:
        executor.spin_once(10.0)
    assert heard == [3.0]
    client.destroy()
    server.destroy()


def test_what_a_plain_function_returns_is_the_tasks_value(
    executor: SingleThreadedExecutor, forgotten: Callable[[Any], Any]
) -> None:
    async def answer() -> int:
        return 42

    task = executor.create_task(lambda: forgotten(answer()))
    executor.spin_once(0)
    assert task.result().__name__ == "answer"
    with pytest.raises(TypeError):
        executor.create_task(answer, 1)  # at once: the coroutine is made here


def test_a_task_that_waits_does_not_execute_and_is_closed_when_it_is_cancelled(
    executor: SingleThreadedExecutor,
) -> None:
    never: Future[None] = Future()
    closed: list[bool] = []

    async def wait() -> None:
        try:
            await never
        finally:
            closed.append(True)

    task = executor.create_task(wait)
    executor.spin_once(0)
    assert not task.executing()
    task.cancel()
    assert closed == [True]
    assert task.cancelled()
    assert not task.done()


def test_an_exception_that_nobody_looked_at_is_said(capfd: pytest.CaptureFixture[str]) -> None:
    for looked_at in (False, True):
        future: Future[None] = Future()
        future.set_exception(ValueError(f"looked at: {looked_at}"))
        if looked_at:
            future.exception()
        del future
    said = capfd.readouterr().err
    assert said == "The following exception was never retrieved: looked at: False\n"


def test_a_future_can_be_awaited_in_asyncio_while_its_loop_spins_the_node(
    ros: Ros, executor: SingleThreadedExecutor
) -> None:
    node = ros.node()
    node.create_service(Trigger, "t", lambda request, response: response)
    client = node.create_client(Trigger, "t")
    executor.add_node(node)

    async def ask() -> Any:
        return await client.call_async(Trigger.Request())

    async def both() -> Any:
        asking = asyncio.ensure_future(ask())
        while not asking.done():
            executor.spin_once(timeout_sec=0.01)
            await asyncio.sleep(0)
        return await asking

    assert isinstance(asyncio.run(both()), Trigger.Response)
