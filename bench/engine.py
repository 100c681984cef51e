"""`python -m bench.engine`: what the embedded engine's messages, calls and goals cost.

Rates beside those of the real rclpy in one process, when that is installed: medians of rounds that
take turns. Absolute rates are this machine's; the ratios are what counts.
"""

from __future__ import annotations

import importlib.util
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

ROUNDS = 5
SECONDS = 0.4  # of each row in each round
GOALS_KEPT = 250


def rate(once: Callable[[], None]) -> float:
    """How often a second."""
    once()
    end, count, begin = time.perf_counter() + SECONDS, 0, time.perf_counter()
    while time.perf_counter() < end:
        once()
        count += 1
    return count / (time.perf_counter() - begin)


def topic(ros: Any, receivers: int, idle: int = 0) -> float:
    """Messages a second to so many receivers, beside so many idle nodes."""
    from std_msgs.msg import Float32

    node, executor, heard = ros.node(), ros.executor, [0]

    def hear(_: object) -> None:
        heard[0] += 1

    for _ in range(receivers):
        node.create_subscription(Float32, "numbers", hear, 10)
    for _ in range(idle):
        ros.node()
    publisher = node.create_publisher(Float32, "numbers", 10)
    while publisher.get_subscription_count() < receivers:
        executor.spin_once(timeout_sec=0.05)
    message = Float32(data=1.0)

    def once() -> None:
        wanted = heard[0] + receivers
        publisher.publish(message)
        while heard[0] < wanted:
            executor.spin_once(timeout_sec=1.0)

    return rate(once)


def service(ros: Any) -> float:
    """Return how many calls a second there are."""
    from std_srvs.srv import Trigger

    node, executor = ros.node(), ros.executor
    node.create_service(Trigger, "ask", lambda _, response: response)
    client = node.create_client(Trigger, "ask")
    while not client.service_is_ready():
        executor.spin_once(timeout_sec=0.05)
    return rate(
        lambda: executor.spin_until_future_complete(client.call_async(Trigger.Request()), 5.0)
    )


def action(ros: Any, kept: int = 0) -> float:
    """Goals with their results a second, while the results of so many others are kept."""
    from archo_interfaces.action import MoveToShelf
    from rclpy.action import ActionClient, ActionServer

    node, executor = ros.node(), ros.executor

    def execute(goal: Any) -> Any:
        goal.succeed()
        return MoveToShelf.Result()

    server = ActionServer(node, MoveToShelf, "move", execute, result_timeout=900)
    client = ActionClient(node, MoveToShelf, "move")
    while not client.server_is_ready():
        executor.spin_once(timeout_sec=0.05)

    def once() -> None:
        sent = client.send_goal_async(MoveToShelf.Goal())
        executor.spin_until_future_complete(sent, 5.0)
        executor.spin_until_future_complete(sent.result().get_result_async(), 5.0)

    for _ in range(kept):
        once()
    found = rate(once)
    server.destroy()
    return found


ROWS: dict[str, Callable[[Any], float]] = {
    "messages to 1 receiver": lambda ros: topic(ros, 1),
    "messages to 10 receivers": lambda ros: topic(ros, 10),
    "messages to 100 receivers": lambda ros: topic(ros, 100),
    "service calls": service,
    "goals and results": action,
    f"the same, {GOALS_KEPT} kept": lambda ros: action(ros, GOALS_KEPT),
}
ONLY_HERE = {"messages beside 1,000 idle nodes": lambda ros: topic(ros, 1, 1000)}


class Ros:
    """One context, one executor."""

    def __init__(self, name: str) -> None:
        from archo_tui.ros import engine

        engine.activate(name)
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        rclpy.init(args=["--ros-args", "--disable-stdout-logs"])
        self.executor: Any = SingleThreadedExecutor()
        self._made = 0

    def node(self) -> Any:
        """Another node, spun by the one executor."""
        from rclpy.node import Node

        self._made += 1
        node = Node(f"bench_{self._made}", namespace=f"/row_{self._made}")
        self.executor.add_node(node)
        return node

    def clear(self) -> None:
        """No node is left."""
        for node in list(self.executor.get_nodes()):
            self.executor.remove_node(node)
            node.destroy_node()


def worker(name: str) -> None:
    """One round of one engine, as JSON."""
    ros, rows = Ros(name), ROWS if name == "ros2" else ROWS | ONLY_HERE
    found = {}
    for row, measure in rows.items():
        found[row] = measure(ros)
        ros.clear()
    print(json.dumps(found))


def main() -> None:
    """Print the table."""
    names = ["embedded"] + ["ros2"] * (importlib.util.find_spec("rclpy") is not None)
    found: dict[str, list[dict[str, float]]] = {name: [] for name in names}
    for _ in range(ROUNDS):
        for name in names:
            command = [sys.executable, "-m", "bench.engine", name]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            found[name].append(json.loads(done.stdout.splitlines()[-1]))
    print(f"{'a second':<34}{'embedded':>10}{'rclpy':>10}{'ratio':>8}")
    for row in ROWS | ONLY_HERE:
        ours = statistics.median(one[row] for one in found["embedded"])
        theirs = [one[row] for one in found.get("ros2", ()) if row in one]
        beside = f"{statistics.median(theirs):10.0f}" if theirs else f"{'-':>10}"
        ratio = f"{ours / statistics.median(theirs):8.1f}" if theirs else f"{'-':>8}"
        print(f"{row:<34}{ours:10.0f}{beside}{ratio}")
    if len(names) == 1:
        print("the real rclpy is not installed: no ratios")


if __name__ == "__main__":
    worker(sys.argv[1]) if sys.argv[1:] else main()
