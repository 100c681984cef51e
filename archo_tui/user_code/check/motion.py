"""The checks of the action move_to_shelf: a goal arrives, and a cancel ends one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient

from archo_tui.user_code.check.checker import ACTIONS, ANSWER, CheckedNode, Checker
from archo_tui.user_code.check.tap import Failed

_MOVE = "/move_to_shelf"
_MAX_MOVE = 8.0  # Seconds; the chapter's move takes 3 s.
_MIN_MOVE = 0.5  # Seconds; of a shorter one, whether feedback or a cancel is heard is chance.
_FEEDBACK_GRACE = 0.5  # Seconds in which feedback may come after the result.
_MAX_CANCEL = 1.0  # Seconds in which a cancel must be answered.
_WAY = [15.0, 12.0, 9.0, 6.0, 3.0, 0.0]  # In m, as feedback tells it of a move that arrives.
_SHELVES = 11, 6  # Not the chapter's 12, which the code may have as a constant.
_TYPE = "archo_interfaces/action/MoveToShelf"
_FIELDS = {
    "Goal": ["shelf_number"],
    "Feedback": ["distance_remaining"],
    "Result": ["success", "final_message"],
}
_ALREADY_ENDED = (
    CancelGoal.Response.ERROR_GOAL_TERMINATED,
    CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID,
)
_TOO_FAST = "the move ended at once: leave 0.5 s between two feedbacks"


class _Move(NamedTuple):
    """A goal that was accepted."""

    nodes: Sequence[CheckedNode]
    handle: Any
    result: Any  # The future of the goal's result.
    began: float  # Monotonic time, s.
    feedback: list[tuple[float, float]]  # When it came, and the distance in m.

    @property
    def way(self) -> list[float]:
        return [distance for _, distance in self.feedback]

    def check_duration(self, end: float) -> None:
        lasted = end - self.began
        if len(self.feedback) > 1:  # On a busy machine the answer may take longer than the move.
            lasted = min(lasted, self.feedback[-1][0] - self.feedback[0][0])
        if lasted < _MIN_MOVE:
            raise Failed(_TOO_FAST)


def _begin_move(checker: Checker, shelf: int) -> _Move:
    nodes = checker.nodes_with(ACTIONS, _MOVE)
    kind = checker.load_type(nodes, ACTIONS, _MOVE, [_TYPE], _FIELDS)
    client, feedback = ActionClient(checker.node, kind, _MOVE), list[tuple[float, float]]()

    def take(message: Any) -> None:
        feedback.append((checker.now(), round(message.feedback.distance_remaining, 3)))

    checker.until(client.server_is_ready, ANSWER, nodes)
    began = checker.now()
    goal = kind.Goal(shelf_number=shelf)
    handle = checker.result(client.send_goal_async(goal, feedback_callback=take), ANSWER, nodes)
    if handle is None:
        raise Failed(f"no answer to the goal in {ANSWER:g} s{checker.stuck(nodes)}")
    if not handle.accepted:
        raise Failed(f"the goal to shelf {shelf} was not accepted")
    return _Move(nodes, handle, handle.get_result_async(), began, feedback)


def check_arrival(checker: Checker) -> None:
    """Send a goal, and check its feedback and its result."""
    shelf = _SHELVES[0]
    move = _begin_move(checker, shelf)
    answer = checker.result(move.result, _MAX_MOVE, move.nodes)
    if answer is None:
        so_far = f"no result in {_MAX_MOVE:g} s; feedback so far: {_join(move.way)}"
        raise Failed(f"{so_far}{checker.stuck(move.nodes)}")
    end = checker.now()
    checker.until(lambda: len(move.feedback) >= len(_WAY), _FEEDBACK_GRACE, move.nodes)
    if answer.status != GoalStatus.STATUS_SUCCEEDED:
        ended = "CANCELED" if answer.status == GoalStatus.STATUS_CANCELED else "ABORTED"
        raise Failed(f"it ended as {ended}: call goal_handle.succeed() before return")
    move.check_duration(end)
    if move.way != _WAY:
        raise Failed(f"the feedback was {_join(move.way)}; the chapter's is {_join(_WAY)}")
    says, words = answer.result.final_message, f"Arrived at shelf {shelf}"
    if says != words:
        hint = f"shelf {shelf} was asked for, and the result says {says!r} instead of {words!r}"
        how = "" if str(shelf) in says else ": take it from goal_handle.request.shelf_number"
        raise Failed(hint + how)
    if not answer.result.success:
        raise Failed("the result says success False: set it to True")


def check_cancel(checker: Checker) -> None:
    """Send a goal, cancel it when its feedback says that 9 m remain, and check its end."""
    move = _begin_move(checker, _SHELVES[1])
    nodes, result = move.nodes, move.result
    checker.until(lambda: 9.0 in move.way or result.done(), _MAX_MOVE, nodes)
    end = checker.now()
    if not checker.until(lambda: 9.0 in move.way, _FEEDBACK_GRACE, nodes):
        move.check_duration(end)
        raise Failed(f"no feedback of 9 m; it was {_join(move.way)}")
    cancel = move.handle.cancel_goal_async()
    if not checker.until(cancel.done, _MAX_CANCEL, nodes):
        busy = checker.busy_line(nodes)
        checker.until(lambda: cancel.done() and result.done(), _MAX_MOVE, nodes)
        how = "while execute sleeps, a single-threaded executor takes no cancel: spin with a "
        how += "MultiThreadedExecutor in main(), or await a future"
        hints = f"{busy}: {how}" if busy else how, _missing_callback_hint(nodes)
        raise Failed("\n".join(hints))
    if not cancel.result().goals_canceling:
        if result.done() or cancel.result().return_code in _ALREADY_ENDED:
            raise Failed(_TOO_FAST)
        checker.until(result.done, _MAX_MOVE, nodes)
        wrong = "the cancel_callback did not accept it: return CancelResponse.ACCEPT"
        raise Failed(_missing_callback_hint(nodes) or wrong)
    answer = checker.result(result, _MAX_MOVE, nodes)
    accepted = "the cancel was accepted,"
    if answer is None:
        raise Failed(f"{accepted} and there is no result{checker.stuck(nodes)}")
    if answer.status == GoalStatus.STATUS_SUCCEEDED:
        how = "look at goal_handle.is_cancel_requested in its loop"
        raise Failed(f"{accepted} but the move went on: {how}")
    if answer.status != GoalStatus.STATUS_CANCELED:
        raise Failed(f"{accepted} but the goal not ended by goal_handle.canceled()")
    if answer.result.success:
        raise Failed("the result of a cancelled move says success True")
    says, words = answer.result.final_message, "Cancelled mid-route"
    if says != words:
        raise Failed(f"the result says {says!r} instead of {words!r}")


def _missing_callback_hint(nodes: Sequence[CheckedNode]) -> str:
    """Return where an ActionServer without cancel_callback is made, with advice, or ""."""
    for node in nodes:
        line, may_accept = node.file.source.action_server() or (0, True)
        if not may_accept:
            why = "ActionServer has no cancel_callback, and rclpy rejects every cancel without one"
            return f"{node.file}:{line}: {why}: one that returns CancelResponse.ACCEPT"
    return ""


def _join(way: Sequence[float]) -> str:
    return ", ".join(f"{distance:g}" for distance in way) or "empty"
