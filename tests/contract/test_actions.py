"""Rule 6 for actions, and that they are three services and two topics."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from archo_interfaces.action import MoveToShelf
from rcl_interfaces.msg import Log
from rclpy.action import ActionServer, CancelResponse, GoalResponse, get_action_names_and_types
from rclpy.executors import MultiThreadedExecutor
from rclpy.qos import qos_profile_action_status_default
from rclpy.task import Future

from tests.support.ros import Ros
from tests.support.waiting import wait_until


class Robot:
    """A server whose goals end when the test says so, in a node of its own."""

    def __init__(self, ros: Ros, **options: Any) -> None:
        self.node = ros.node("server")
        self.goals: list[Any] = []
        self.finish: Future[str] = Future()
        self.server = ActionServer(
            self.node,
            MoveToShelf,
            "move",
            self.execute,
            **options,
        )
        self.executor = ros.spin(self.node)
        self.client = ros.action_client(MoveToShelf, "move")
        assert self.client.wait_for_server(10.0)

    async def execute(self, goal: Any) -> Any:
        self.goals.append(goal)
        goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=1.0))
        end = await self.finish
        if end:
            getattr(goal, end)()
        return MoveToShelf.Result(final_message=end)

    def end(self, how: str) -> None:
        self.finish.set_result(how)
        self.executor.create_task(lambda: None)


def send(ros: Ros, robot: Robot, **options: Any) -> Any:
    return ros.result(robot.client.send_goal_async(MoveToShelf.Goal(shelf_number=3), **options))


def test_a_goal_is_accepted_gives_feedback_and_a_result(ros: Ros) -> None:
    robot = Robot(ros)
    feedback: list[float] = []
    handle = send(
        ros, robot, feedback_callback=lambda m: feedback.append(m.feedback.distance_remaining)
    )
    assert handle.accepted
    wait_until(lambda: handle.status == GoalStatus.STATUS_EXECUTING)
    wait_until(lambda: feedback == [1.0])
    answer = handle.get_result_async()
    robot.end("succeed")
    assert ros.result(answer).status == GoalStatus.STATUS_SUCCEEDED
    assert ros.result(answer).result.final_message == "succeed"
    assert robot.goals[0].request.shelf_number == 3
    wait_until(lambda: handle.status == GoalStatus.STATUS_SUCCEEDED)


@pytest.mark.parametrize(
    ("end", "status"),
    [
        ("abort", GoalStatus.STATUS_ABORTED),
        ("", GoalStatus.STATUS_ABORTED),  # no terminal state
        ("no_such_method", GoalStatus.STATUS_ABORTED),  # an exception
    ],
)
def test_a_result_can_be_asked_for_after_the_end_and_twice(
    ros: Ros, end: str, status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    warnings: list[str] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lambda m: warnings.append(m.msg), 50)
    robot = Robot(ros)
    handle = send(ros, robot)
    robot.end(end)
    wait_until(lambda: robot.goals and not robot.goals[0].is_active)
    for _ in range(2):
        assert ros.result(handle.get_result_async()).status == status
    if not end:
        wait_until(lambda: any("Goal state not set, assuming aborted" in w for w in warnings))


def test_a_goal_that_a_callback_refuses_is_not_executed_and_its_result_is_unknown(ros: Ros) -> None:
    robot = Robot(ros, goal_callback=lambda goal: GoalResponse.REJECT)
    assert not send(ros, robot).accepted
    assert robot.client.send_goal(MoveToShelf.Goal()).status == GoalStatus.STATUS_UNKNOWN
    assert robot.goals == []


def test_a_cancel_is_rejected_by_default(ros: Ros) -> None:
    robot = Robot(ros)
    handle = send(ros, robot)
    wait_until(lambda: robot.goals)
    assert len(ros.result(handle.cancel_goal_async()).goals_canceling) == 0
    assert not robot.goals[0].is_cancel_requested
    robot.end("succeed")
    assert ros.result(handle.get_result_async()).status == GoalStatus.STATUS_SUCCEEDED


def test_an_accepted_cancel_is_requested_then_canceled(ros: Ros) -> None:
    robot = Robot(ros, cancel_callback=lambda goal: CancelResponse.ACCEPT)
    handle = send(ros, robot)
    wait_until(lambda: robot.goals)
    assert len(ros.result(handle.cancel_goal_async()).goals_canceling) == 1
    assert robot.goals[0].is_cancel_requested
    wait_until(lambda: handle.status == GoalStatus.STATUS_CANCELING)
    robot.end("canceled")
    assert ros.result(handle.get_result_async()).status == GoalStatus.STATUS_CANCELED


def test_a_goal_that_was_cancelled_before_its_execution_is_executed_as_such(ros: Ros) -> None:
    held: list[Any] = []
    robot = Robot(
        ros,
        cancel_callback=lambda goal: CancelResponse.ACCEPT,
        handle_accepted_callback=held.append,
    )
    handle = send(ros, robot)
    assert len(ros.result(handle.cancel_goal_async()).goals_canceling) == 1
    robot.executor.create_task(held[0].execute)
    wait_until(lambda: robot.goals)
    assert robot.goals[0].is_cancel_requested
    robot.end("canceled")
    assert ros.result(handle.get_result_async()).status == GoalStatus.STATUS_CANCELED


def test_illegal_ends_raise(ros: Ros) -> None:
    robot = Robot(ros)
    send(ros, robot)
    wait_until(lambda: robot.goals)
    with pytest.raises(RuntimeError):
        robot.goals[0].canceled()  # nobody asked for a cancel
    for use in (robot.client.send_goal_async, robot.goals[0].publish_feedback):
        with pytest.raises(TypeError):
            use(MoveToShelf.Result())
    robot.end("succeed")
    wait_until(lambda: not robot.goals[0].is_active)
    with pytest.raises(RuntimeError):
        robot.goals[0].abort()


def test_an_action_is_three_services_and_two_topics(ros: Ros) -> None:
    robot = Robot(ros)
    node = ros.node("observer")
    prefix, kind = "/move/_action", "archo_interfaces/action/MoveToShelf"

    def services() -> dict[str, list[str]]:
        return {n: t for n, t in node.get_service_names_and_types() if n.startswith(prefix)}

    def topics() -> dict[str, list[str]]:
        return {n: t for n, t in node.get_topic_names_and_types() if n.startswith(prefix)}

    wait_until(lambda: len(services()) == 3 and len(topics()) == 2)
    assert services() == {
        f"{prefix}/send_goal": [f"{kind}_SendGoal"],
        f"{prefix}/cancel_goal": ["action_msgs/srv/CancelGoal"],
        f"{prefix}/get_result": [f"{kind}_GetResult"],
    }
    assert topics() == {
        f"{prefix}/feedback": [f"{kind}_FeedbackMessage"],
        f"{prefix}/status": ["action_msgs/msg/GoalStatusArray"],
    }
    assert get_action_names_and_types(node) == [("/move", [kind])]
    robot.end("succeed")


def test_another_client_can_cancel_all_goals(ros: Ros) -> None:
    robot = Robot(ros, cancel_callback=lambda goal: CancelResponse.ACCEPT)
    handle = send(ros, robot)
    wait_until(lambda: robot.goals)
    stranger = ros.spun("stranger").create_client(CancelGoal, "move/_action/cancel_goal")
    assert stranger.wait_for_service(10.0)
    everything = CancelGoal.Request(goal_info=GoalInfo())
    assert len(ros.result(stranger.call_async(everything)).goals_canceling) == 1
    robot.end("canceled")
    assert ros.result(handle.get_result_async()).status == GoalStatus.STATUS_CANCELED


def test_a_blocking_execute_freezes_its_node_until_the_goal_ends(ros: Ros) -> None:
    node = ros.node("server")
    go = threading.Event()

    def execute(goal: Any) -> Any:
        go.wait(10)
        goal.succeed()
        return MoveToShelf.Result(success=True)

    ActionServer(
        node, MoveToShelf, "move", execute, cancel_callback=lambda goal: CancelResponse.ACCEPT
    )
    ros.spin(node)
    client = ros.action_client(MoveToShelf, "move")
    assert client.wait_for_server(10.0)
    handle = ros.result(client.send_goal_async(MoveToShelf.Goal(shelf_number=1)))
    cancel = handle.cancel_goal_async()
    assert not cancel.done()
    go.set()
    answer = ros.result(cancel)
    assert answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED


def test_a_multi_threaded_executor_takes_a_cancel_during_a_blocking_execute(ros: Ros) -> None:
    node = ros.node("server")
    stop = threading.Event()

    def execute(goal: Any) -> Any:
        wait_until(lambda: goal.is_cancel_requested or stop.is_set())
        goal.canceled()
        return MoveToShelf.Result(final_message="canceled")

    ActionServer(
        node, MoveToShelf, "move", execute, cancel_callback=lambda goal: CancelResponse.ACCEPT
    )
    ros.spin(node, executor=MultiThreadedExecutor(4, context=ros.context))
    client = ros.action_client(MoveToShelf, "move")
    assert client.wait_for_server(10.0)
    handle = ros.result(client.send_goal_async(MoveToShelf.Goal(shelf_number=1)))
    assert len(ros.result(handle.cancel_goal_async()).goals_canceling) == 1
    assert ros.result(handle.get_result_async()).status == GoalStatus.STATUS_CANCELED


def test_a_status_tells_of_every_goal_that_is_kept(ros: Ros) -> None:
    robot = Robot(ros)
    statuses: list[list[int]] = []
    node = ros.spun("watcher")
    node.create_subscription(
        GoalStatusArray,
        "move/_action/status",
        lambda m: statuses.append([s.status for s in m.status_list]),
        qos_profile_action_status_default,
    )
    for number in (1, 2):
        handle = send(ros, robot)
        wait_until(lambda number=number: len(robot.goals) == number)  # type: ignore[misc]
        robot.end("succeed")
        ros.result(handle.get_result_async())
    done = GoalStatus.STATUS_SUCCEEDED
    wait_until(lambda: bool(statuses) and statuses[-1] == [done, done])
    late: list[int] = []
    node.create_subscription(
        GoalStatusArray,
        "move/_action/status",
        lambda m: late.append(len(m.status_list)),
        qos_profile_action_status_default,
    )
    wait_until(lambda: late == [2])
