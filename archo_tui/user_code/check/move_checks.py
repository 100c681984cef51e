"""The checks of the action move_to_shelf."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient

from archo_tui.robot.messages.types import kinds, load_class
from archo_tui.user_code.check import near_names
from archo_tui.user_code.check.check_runner import ANSWER, CheckedNode, CheckRunner, CrashedError
from archo_tui.user_code.check.tap import Result

MOVE = "move_to_shelf"
_ARRIVES = "move_to_shelf gives feedback 15, 12 ... 0 and arrives"
_CANCELS = "a cancel at 9 m ends the move as CANCELED"
_MAX_MOVE = 8.0  # Seconds; the chapter's move takes 3 s.
_MIN_MOVE = 0.5  # Seconds; the feedback of a shorter move may get lost.
_FEEDBACK_GRACE = 0.5  # Seconds in which feedback may come after the result.
_MAX_CANCEL = 1.0  # Seconds in which a cancel must be answered.
_FEEDBACK = [15.0, 12.0, 9.0, 6.0, 3.0, 0.0]  # In m, of a move that arrives.
_SHELVES = 11, 6  # Not the chapter's 12, which the code may have as a constant.
_FIELDS = {
    "Goal": "shelf_number",
    "Feedback": "distance_remaining",
    "Result": "final_message",
}
_STATUS_NAMES = {
    GoalStatus.STATUS_SUCCEEDED: "SUCCEEDED",
    GoalStatus.STATUS_CANCELED: "CANCELED",
    GoalStatus.STATUS_ABORTED: "ABORTED",
}
_FROM_REQUEST = ": take it from goal_handle.request.shelf_number"
_ALREADY_ENDED = (
    CancelGoal.Response.ERROR_GOAL_TERMINATED,
    CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID,
)
_TOO_FAST = "the move ended at once: leave 0.5 s between two feedbacks"
_NOT_ACCEPTED = "the cancel_callback did not accept it: return CancelResponse.ACCEPT"


def move_checks(runner: CheckRunner) -> Iterator[Result]:
    """Yield the outcome of the two checks of the action: a goal arrives, and a cancel ends one.

    Goals are sent, and nodes that crash are restarted. If no node serves the action, both checks
    are skipped; they fail if a node serves one with a similar name, or with other fields.
    """
    found = runner.nodes()
    nodes = [node for node in found if f"/{MOVE}" in node.actions]
    if not nodes:
        others = {name for node in found for name in node.actions}
        for title in (_ARRIVES, _CANCELS):
            yield near_names.missing_result(runner, title, MOVE, "serve", "action", others)
        return
    type_name = nodes[0].actions[f"/{MOVE}"]
    action_class = load_class(type_name)
    lacks = [field for part, field in _FIELDS.items() if field not in _fields(action_class, part)]
    if lacks:
        hint = f"it is a {type_name}, without {', '.join(lacks)}: the chapter's is MoveToShelf"
        yield Result(_ARRIVES, hint)
        yield Result(_CANCELS, hint)
        return
    client = ActionClient(runner.node, action_class, MOVE)
    move = _MoveProbe(runner, nodes, client, action_class)
    for title, ask in ((_ARRIVES, move.check_arrival), (_CANCELS, move.check_cancel)):
        since = len(runner.printed)
        try:
            hint = ask()
        except CrashedError as error:
            hint = str(error)
        if hint:  # What a process prints comes a little later.
            runner.spin_until(partial(runner.last_exception, since), _FEEDBACK_GRACE)
            hint = runner.last_exception(since) or hint
        yield Result(title, hint)
        runner.restart_crashed()
    client.destroy()


def _fields(action_class: Any, part: str) -> set[str]:
    return set(kinds(getattr(action_class, part))) if action_class is not None else set()


class _MoveProbe:
    """An action client that sends goals, and checks feedback and results."""

    def __init__(
        self, runner: CheckRunner, nodes: Sequence[CheckedNode], client: Any, action_class: Any
    ) -> None:
        self._runner, self._client, self._action_class = runner, client, action_class
        self._nodes = nodes
        self._is_too_fast = False  # Then whether a cancel is in time is chance.

    def _until(self, holds: Any, seconds: float) -> bool:
        return self._runner.spin_until(holds, seconds, self._nodes)

    def _send(self, shelf: int) -> tuple[Any, list[float], str]:
        """Send a goal, and wait for the answer, for ANSWER seconds at most."""
        way: list[float] = []
        self._came: list[float] = []

        def take(message: Any) -> None:
            self._came.append(self._runner.now())
            way.append(round(message.feedback.distance_remaining, 3))

        self._until(self._client.server_is_ready, ANSWER)
        sent = self._client.send_goal_async(
            self._action_class.Goal(shelf_number=shelf), feedback_callback=take
        )
        if not self._until(sent.done, ANSWER):
            busy = self._runner.busy_line(self._nodes)
            why = f": a callback does not return, {busy}" if busy else ""
            return None, way, f"no answer to the goal in {ANSWER:g} s{why}"
        handle = sent.result()
        if not handle.accepted:
            return None, way, f"the goal to shelf {shelf} was not accepted"
        return handle, way, ""

    def check_arrival(self) -> str:
        """Send a goal, wait 8 s at most for its end, and return what is wrong, or ""."""
        shelf = _SHELVES[0]
        began = self._runner.now()
        handle, way, why = self._send(shelf)
        if handle is None:
            return why
        future = handle.get_result_async()
        if not self._until(future.done, _MAX_MOVE):
            self._runner.wake(self._nodes)
            busy = self._runner.busy_line(self._nodes)
            where = f"; execute is at {busy}" if busy else ""
            return f"no result in {_MAX_MOVE:g} s; feedback so far: {way}{where}"
        lasted = self._runner.now() - began
        self._until(lambda: len(way) >= len(_FEEDBACK), _FEEDBACK_GRACE)
        answer, words = future.result(), f"Arrived at shelf {shelf}"
        if answer.status != GoalStatus.STATUS_SUCCEEDED:
            ended = _STATUS_NAMES.get(answer.status, str(answer.status))
            return f"it ended as {ended}: call goal_handle.succeed() before return"
        if len(way) > 1:  # On a busy machine the answer to the goal may take longer than the move.
            lasted = min(lasted, self._came[-1] - self._came[0])
        self._is_too_fast = lasted < _MIN_MOVE
        if self._is_too_fast:
            return _TOO_FAST
        if way != _FEEDBACK:
            return f"the feedback was {_join(way)}; the chapter's is {_join(_FEEDBACK)}"
        if answer.result.final_message != words:
            hint = f"shelf {shelf} was asked for, and the result says"
            where = "" if str(shelf) in answer.result.final_message else _FROM_REQUEST
            return f"{hint} {answer.result.final_message!r} instead of {words!r}{where}"
        return "" if answer.result.success else "the result says success False: set it to True"

    def check_cancel(self) -> str:
        """Send a goal, cancel it when its feedback says that 9 m remain, and wait for its end."""
        if self._is_too_fast:
            return _TOO_FAST
        handle, way, why = self._send(_SHELVES[1])
        if handle is None:
            return why
        future = handle.get_result_async()
        self._until(lambda: 9.0 in way or future.done(), _MAX_MOVE)
        if not self._until(lambda: 9.0 in way, _FEEDBACK_GRACE):
            return f"no feedback of 9 m; it was {_join(way)}"
        asked = handle.cancel_goal_async()
        if not self._until(asked.done, _MAX_CANCEL):
            busy = self._runner.busy_line(self._nodes)
            self._until(lambda: asked.done() and future.done(), _MAX_MOVE)
            return "\n".join(
                filter(None, [_blocked_executor_hint(busy), self._missing_callback_hint()])
            )
        if not asked.result().goals_canceling:
            if asked.result().return_code in _ALREADY_ENDED or future.done():
                return _TOO_FAST
            self._until(future.done, _MAX_MOVE)
            return self._missing_callback_hint() or _NOT_ACCEPTED
        if not self._until(future.done, _MAX_MOVE):
            self._runner.wake(self._nodes)
        return self._check_cancelled_end(future)

    def _check_cancelled_end(self, future: Any) -> str:
        """Return what is wrong with the end of a goal whose cancel was accepted, or ""."""
        if not future.done():
            busy = self._runner.busy_line(self._nodes)
            return f"the cancel was accepted, and there is no result{': ' * bool(busy)}{busy}"
        answer = future.result()
        if answer.status == GoalStatus.STATUS_SUCCEEDED:
            return (
                "the cancel was accepted, but the move went on: look at "
                "goal_handle.is_cancel_requested in its loop"
            )
        if answer.status != GoalStatus.STATUS_CANCELED:
            return "the cancel was accepted, but the goal not ended by goal_handle.canceled()"
        if answer.result.success:
            return "the result of a cancelled move says success True"
        words = answer.result.final_message
        wanted = "Cancelled mid-route"
        return "" if words == wanted else f"the result says {words!r} instead of {wanted!r}"

    def _missing_callback_hint(self) -> str:
        """Return where an ActionServer without cancel_callback is made, with advice, or ""."""
        for node in self._nodes:
            found = node.file.source.action_server()
            if found is not None and not found[1]:
                return (
                    f"{node.file}:{found[0]}: ActionServer has no cancel_callback, and rclpy "
                    "rejects every cancel without one: one that returns CancelResponse.ACCEPT"
                )
        return ""


def _blocked_executor_hint(busy: str) -> str:
    """Return the advice for a node that takes no cancel while it executes a goal."""
    where = f"{busy}: " if busy else ""
    return (
        f"{where}while execute sleeps, a single-threaded executor takes no cancel: spin with a "
        "MultiThreadedExecutor in main(), or await a future"
    )


def _join(way: Sequence[float]) -> str:
    return ", ".join(f"{distance:g}" for distance in way) or "empty"
