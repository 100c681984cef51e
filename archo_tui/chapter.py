"""`--check`: asks nodes of the user's own what the textbook's chapter asks of them, in TAP.

https://testanything.org: a line a check, `ok` or `not ok`, with a hint below the latter. A check of
something that no node of the files offers is skipped.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from statistics import median
from typing import Any, NamedTuple

from action_msgs.msg import GoalStatus
from rcl_interfaces.msg import Log
from rclpy.action import ActionClient, get_action_server_names_and_types_by_node
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from archo_tui.robot import interfaces
from archo_tui.robot.graph import logger_node
from archo_tui.session import Session

_SLICE = 0.05  # s of one turn of the checker's executor
_ANSWER = 3.0  # s until an answer or a log line must be there
_AGAIN = 0.1  # s between two battery levels that the checker publishes
_WHOLE_MOVE = 8.0  # s that the chapter's move of 3 s may take
_PERIOD = 0.5, 1.5  # s between two battery levels, where the chapter asks for one a second
_LEVELS = 4  # battery levels that are looked at
_WAY = [15.0, 12.0, 9.0, 6.0, 3.0, 0.0]  # m, the feedback of a whole move
_SHELF = 12


class Result(NamedTuple):
    """How one check ended; without `hint` it passed."""

    name: str
    hint: str = ""
    skipped: str = ""  # why there was nothing to check

    def lines(self, number: int) -> Iterator[str]:
        """As TAP has it."""
        if self.skipped:
            yield f"ok {number} - {self.name} # SKIP {self.skipped}"
        else:
            yield f"{'not ok' if self.hint else 'ok'} {number} - {self.name}"
        if self.hint:
            yield f"# {self.hint}"


class Chapter:
    """The checks, on the nodes that a session hosts; each spins the checker's own node."""

    def __init__(self, session: Session, radius: float) -> None:
        """`radius` is the wheel_radius (m) of a parameter file that all nodes were given."""
        self._radius = radius
        context = session.host.nodes[0].node.context
        self._hosted = [hosted.node for hosted in session.host.nodes]
        self._node = Node("_archo_check", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        self._logs: list[Log] = []
        self._node.create_subscription(Log, "/rosout", self._logs.append, 100)

    def results(self) -> Iterator[Result]:
        """One after the other; what stops the robot comes last."""
        yield from self._battery()
        yield self._dashboard()
        yield from self._parameters()
        yield from self._move()
        yield self._service("reset_encoder", (True, "Encoder reset to zero"))
        yield self._service("emergency_stop", None)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown(0)
        self._node.destroy_node()

    def _until(self, holds: Callable[[], object], seconds: float) -> bool:
        """Spin until it holds; False when the time is over."""
        end = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=_SLICE)
        return True

    # topics

    def _battery(self) -> Iterator[Result]:
        rate = "battery_level is published about once a second"
        falls = "the battery level only falls, and stays within 0 .. 100"
        made = self._type(self._node.get_publishers_info_by_topic("battery_level"))
        if made is None:
            yield from (_skip(name, "battery_level") for name in (rate, falls))
            return
        heard: list[tuple[float, float]] = []

        def take(message: Any) -> None:
            heard.append((time.monotonic(), _level(message)))

        subscription = self._node.create_subscription(made, "battery_level", take, 10)
        self._until(lambda: len(heard) >= _LEVELS, _LEVELS * _PERIOD[1])
        self._node.destroy_subscription(subscription)
        if len(heard) < 2:
            hint = f"{len(heard)} messages in {_LEVELS * _PERIOD[1]:g} s: create_timer(1.0, ...)"
            yield Result(rate, hint)
            yield Result(falls, "too few messages to tell")
            return
        period = median(b - a for (a, _), (b, _) in pairwise(heard))
        well = _PERIOD[0] <= period <= _PERIOD[1]
        hint = f"one every {period:.2f} s: the first argument of create_timer is in seconds"
        yield Result(rate, "" if well else hint)
        levels = [level for _, level in heard]
        inside = all(0.0 <= level <= 100.0 for level in levels)
        sinks = all(b <= a for a, b in pairwise(levels))
        hint = "" if inside and sinks else f"heard {', '.join(f'{v:g}' for v in levels)}"
        yield Result(falls, hint)

    def _dashboard(self) -> Result:
        name = "a level below 20 % is logged as a warning"
        listening = self._node.get_subscriptions_info_by_topic("battery_level")
        names = {f"{i.node_namespace.rstrip('/')}/{i.node_name}" for i in listening}
        ours = {node.get_fully_qualified_name() for node in self._hosted}
        made = self._type(listening)
        if made is None or not names & ours:
            return Result(name, skipped="no node subscribes to battery_level")
        publisher = self._node.create_publisher(made, "battery_level", 10)
        message = made()
        setattr(message, "percentage" if hasattr(message, "percentage") else "data", 15.0)
        if hasattr(message, "battery_health"):
            message.battery_health = "warning"

        def warned() -> bool:
            return any(
                log.level >= 30 and logger_node(log.name) in names & ours for log in self._logs
            )

        # again and again: it may not have met the node yet
        timer = self._node.create_timer(_AGAIN, lambda: publisher.publish(message))
        found = self._until(warned, _ANSWER)
        self._node.destroy_timer(timer)
        self._node.destroy_publisher(publisher)
        hint = "15.0 was published, and nothing logged: self.get_logger().warn(...) below 20.0"
        return Result(name, "" if found else hint)

    # parameters

    def _parameters(self) -> Iterator[Result]:
        declared = "the parameters max_speed and wheel_radius are declared"
        loaded = "parameters are loaded from a YAML file"
        known = {
            name: node.get_parameter(name)
            for node in self._hosted
            for name in ("max_speed", "wheel_radius")
            if node.has_parameter(name)
        }
        if not known:
            why = "no node declares max_speed or wheel_radius"
            yield from (Result(name, skipped=why) for name in (declared, loaded))
            return
        missing = {"max_speed", "wheel_radius"} - known.keys()
        hint = f"not declared: {', '.join(missing)}: self.declare_parameter(name, value)"
        yield Result(declared, hint if missing else "")
        radius = known.get("wheel_radius", Parameter("wheel_radius", value=0.0)).value
        hint = f"wheel_radius is {radius}, and the file says {self._radius:g}: use get_parameter"
        yield Result(loaded, "" if radius == self._radius else hint)

    # services and the action

    def _service(self, name: str, expected: tuple[bool, str] | None) -> Result:
        said = f"answers {expected[0]}, '{expected[1]}'" if expected else "answers"
        title = f"{name} {said}"
        types = dict(
            pair
            for node in self._hosted
            for pair in self._node.get_service_names_and_types_by_node(
                node.get_name(), node.get_namespace()
            )
        )
        full = next((full for full in types if full.rpartition("/")[2] == name), None)
        made = interfaces.load(types[full][0]) if full is not None else None
        if full is None or made is None:
            return _skip(title, name)
        client = self._node.create_client(made, full)
        self._until(client.service_is_ready, _ANSWER)
        future = client.call_async(made.Request())
        if not self._until(future.done, _ANSWER):
            return Result(title, f"no answer in {_ANSWER:g} s: does the callback return response?")
        answer = interfaces.outcome(future.result())
        if expected is None or (answer.ok, answer.text) == expected:
            return Result(title)
        return Result(title, f"answered {answer.ok}, {answer.text!r}")

    def _move(self) -> Iterator[Result]:
        whole = "move_to_shelf gives feedback 15, 12 ... 0 and arrives"
        cancel = "a cancel at 9 m ends the move as CANCELED"
        found = [
            (name, types[0])
            for node in self._hosted
            for name, types in get_action_server_names_and_types_by_node(
                self._node, node.get_name(), node.get_namespace()
            )
            if name.rpartition("/")[2] == "move_to_shelf"
        ]
        made = interfaces.load(found[0][1]) if found else None
        if made is None:
            yield from (_skip(name, "move_to_shelf") for name in (whole, cancel))
            return
        client = ActionClient(self._node, made, found[0][0])
        self._until(client.server_is_ready, _ANSWER)
        yield Result(whole, self._whole(client, made))
        yield Result(cancel, self._cancelled(client, made))
        client.destroy()

    def _send(self, client: Any, made: Any) -> tuple[Any, list[float]]:
        """The handle of an accepted goal, or None, and its feedback as it comes."""
        way: list[float] = []

        def take(message: Any) -> None:
            way.append(round(message.feedback.distance_remaining, 3))

        sent = client.send_goal_async(made.Goal(shelf_number=_SHELF), feedback_callback=take)
        self._until(sent.done, _ANSWER)
        handle = sent.result() if sent.done() else None
        return (handle if handle is not None and handle.accepted else None), way

    def _whole(self, client: Any, made: Any) -> str:
        handle, way = self._send(client, made)
        if handle is None:
            return f"the goal to shelf {_SHELF} was not accepted"
        future = handle.get_result_async()
        if not self._until(future.done, _WHOLE_MOVE):
            return f"no result in {_WHOLE_MOVE:g} s; feedback so far: {way}"
        answer, words = future.result(), f"Arrived at shelf {_SHELF}"
        if answer.status != GoalStatus.STATUS_SUCCEEDED:
            return f"it ended with status {answer.status}: is goal_handle.succeed() called?"
        if way != _WAY:
            return f"the feedback was {way}"
        if not answer.result.success or answer.result.final_message != words:
            return f"the result is {answer.result.success}, {answer.result.final_message!r}"
        return ""

    def _cancelled(self, client: Any, made: Any) -> str:
        handle, way = self._send(client, made)
        if handle is None:
            return "the second goal was not accepted"
        if not self._until(lambda: 9.0 in way, _WHOLE_MOVE):
            return f"no feedback of 9 m; it was {way}"
        asked = handle.cancel_goal_async()
        future = handle.get_result_async()
        in_time = self._until(asked.done, 1.0)
        self._until(lambda: asked.done() and future.done(), _WHOLE_MOVE)
        if not in_time:
            return (
                "while execute sleeps, a single-threaded executor takes no cancel: "
                "await a future, or spin with a MultiThreadedExecutor"
            )
        if not asked.done() or not len(asked.result().goals_canceling):
            return "rclpy rejects every cancel unless a cancel_callback accepts it"
        answer = future.result() if future.done() else None
        if answer is None or answer.status != GoalStatus.STATUS_CANCELED:
            return "the cancel was accepted, but the goal not ended by goal_handle.canceled()"
        words = answer.result.final_message
        return "" if words == "Cancelled mid-route" else f"the result says {words!r}"

    def _type(self, ends: Sequence[Any]) -> Any:
        """The class of the messages of a topic; None when nobody has it, or it is not here."""
        types = {end.topic_type for end in ends if end.node_name != self._node.get_name()}
        return interfaces.load(types.pop()) if len(types) == 1 else None


def _skip(name: str, what: str) -> Result:
    return Result(name, skipped=f"no node offers {what}")


def _level(message: Any) -> float:
    return float(getattr(message, "percentage", getattr(message, "data", float("nan"))))


def check(session: Session, radius: float, say: Callable[[str], None]) -> int:
    """Run every check, a line at a time; returns the exit code: 0 when none failed."""
    chapter = Chapter(session, radius)
    failed = count = 0
    say("TAP version 13")
    try:
        for count, result in enumerate(chapter.results(), 1):
            failed += bool(result.hint)
            for line in result.lines(count):
                say(line)
    finally:
        chapter.close()
    say(f"1..{count}")
    return 1 if failed else 0
