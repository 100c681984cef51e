"""The action move_to_shelf."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, get_action_server_names_and_types_by_node

from archo_tui.chapter import names
from archo_tui.chapter.asker import ANSWER, Asker, CrashedError
from archo_tui.chapter.tap import Result
from archo_tui.hosting.host import HostedNode
from archo_tui.robot import message_classes

MOVE = "move_to_shelf"
_WHOLE = "move_to_shelf gives feedback 15, 12 ... 0 and arrives"
_CANCEL = "a cancel at 9 m ends the move as CANCELED"
_WHOLE_MOVE = 8.0  # s that the chapter's move of 3 s may take
_SHORTEST = 0.5  # s that a move takes at least: feedback may get lost behind its end
_LATE = 0.5  # s in which feedback may come behind the result
_TAKEN = 1.0  # s in which a cancel must be answered
_WAY = [15.0, 12.0, 9.0, 6.0, 3.0, 0.0]  # m, the feedback of a whole move
_SHELVES = 11, 6  # not the chapter's 12, which may stand in the code
_FIELDS = {
    "Goal": "shelf_number",
    "Feedback": "distance_remaining",
    "Result": "final_message",
}
_NAMES = {
    GoalStatus.STATUS_SUCCEEDED: "SUCCEEDED",
    GoalStatus.STATUS_CANCELED: "CANCELED",
    GoalStatus.STATUS_ABORTED: "ABORTED",
}
_FROM_REQUEST = ": take it from goal_handle.request.shelf_number"
_OVER = CancelGoal.Response.ERROR_GOAL_TERMINATED, CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
_TOO_FAST = "the move ended at once: leave 0.5 s between two feedbacks"
_NOT_ACCEPTED = "the cancel_callback did not accept it: return CancelResponse.ACCEPT"


def moves(asker: Asker) -> Iterator[Result]:
    """The two checks."""
    found = asker.look(
        lambda node: dict(
            get_action_server_names_and_types_by_node(
                asker.node, node.get_name(), node.get_namespace()
            )
        )
    )
    nodes = [hosted for hosted, actions in found.items() if f"/{MOVE}" in actions]
    if not nodes:
        others = {name for actions in found.values() for name in actions}
        for title in (_WHOLE, _CANCEL):
            yield names.missing(asker, title, MOVE, "serve", "action", others)
        return
    named = found[nodes[0]][f"/{MOVE}"][0]
    made = message_classes.load(named)
    lacks = [field for part, field in _FIELDS.items() if field not in _fields(made, part)]
    if lacks:
        said = f"it is a {named}, without {', '.join(lacks)}: the chapter's is MoveToShelf"
        yield Result(_WHOLE, said)
        yield Result(_CANCEL, said)
        return
    client = ActionClient(asker.node, made, MOVE)
    move = _Move(asker, nodes, client, made)
    for title, ask in ((_WHOLE, move.whole), (_CANCEL, move.cancelled)):
        since = len(asker.printed)
        try:
            said = ask()
        except CrashedError as error:
            said = str(error)
        raised = asker.raised(since) if said else ""
        yield Result(title, raised or said)
        asker.nodes()
    client.destroy()


def _fields(made: Any, part: str) -> set[str]:
    return message_classes.fields(getattr(made, part)) if made is not None else set()


class _Move:
    """Sends goals, and looks at what comes of them."""

    def __init__(self, asker: Asker, nodes: Sequence[HostedNode], client: Any, made: Any) -> None:
        self._asker, self._client, self._made = asker, client, made
        self._names = {hosted.name for hosted in nodes}

    @property
    def _nodes(self) -> list[HostedNode]:
        """Those that serve the action, as they run now."""
        return [hosted for hosted in self._asker.running() if hosted.name in self._names]

    def _until(self, holds: Any, seconds: float) -> bool:
        return self._asker.until(holds, seconds, self._nodes)

    def _send(self, shelf: int) -> tuple[Any, list[float], str]:
        """The handle of an accepted goal, its feedback as it comes, or why there is none."""
        way: list[float] = []

        def take(message: Any) -> None:
            way.append(round(message.feedback.distance_remaining, 3))

        self._until(self._client.server_is_ready, ANSWER)
        sent = self._client.send_goal_async(
            self._made.Goal(shelf_number=shelf), feedback_callback=take
        )
        if not self._until(sent.done, ANSWER):
            busy = self._asker.busy(self._nodes)
            why = f": a callback does not return, {busy}" if busy else ""
            return None, way, f"no answer to the goal in {ANSWER:g} s{why}"
        handle = sent.result()
        if not handle.accepted:
            return None, way, f"the goal to shelf {shelf} was not accepted"
        return handle, way, ""

    def whole(self) -> str:
        """What is wrong with a whole move."""
        shelf = _SHELVES[0]
        began = self._asker.now()
        handle, way, why = self._send(shelf)
        if handle is None:
            return why
        future = handle.get_result_async()
        if not self._until(future.done, _WHOLE_MOVE):
            busy = self._asker.busy(self._nodes)
            where = f"; execute is at {busy}" if busy else ""
            return f"no result in {_WHOLE_MOVE:g} s; feedback so far: {way}{where}"
        lasted = self._asker.now() - began
        self._until(lambda: len(way) >= len(_WAY), _LATE)
        answer, words = future.result(), f"Arrived at shelf {shelf}"
        if answer.status != GoalStatus.STATUS_SUCCEEDED:
            ended = _NAMES.get(answer.status, str(answer.status))
            return f"it ended as {ended}: call goal_handle.succeed() before return"
        if lasted < _SHORTEST:
            return _TOO_FAST
        if way != _WAY:
            return f"the feedback was {_listed(way)}; the chapter's is {_listed(_WAY)}"
        if answer.result.final_message != words:
            said = f"shelf {shelf} was asked for, and the result says"
            where = "" if str(shelf) in answer.result.final_message else _FROM_REQUEST
            return f"{said} {answer.result.final_message!r} instead of {words!r}{where}"
        return "" if answer.result.success else "the result says success False: set it to True"

    def cancelled(self) -> str:
        """What is wrong with a cancel at 9 m."""
        began = self._asker.now()
        handle, way, why = self._send(_SHELVES[1])
        if handle is None:
            return why
        future = handle.get_result_async()
        self._until(lambda: 9.0 in way or future.done(), _WHOLE_MOVE)
        if future.done() and self._asker.now() - began < _SHORTEST:
            return _TOO_FAST
        if not self._until(lambda: 9.0 in way, _LATE):
            return f"no feedback of 9 m; it was {_listed(way)}"
        asked = handle.cancel_goal_async()
        if not self._until(asked.done, _TAKEN):
            busy = self._asker.busy(self._nodes)
            self._until(lambda: asked.done() and future.done(), _WHOLE_MOVE)
            return "\n".join(filter(None, [_blocked(busy), self._no_callback()]))
        if not asked.result().goals_canceling:
            if asked.result().return_code in _OVER or future.done():
                return _TOO_FAST
            self._until(future.done, _WHOLE_MOVE)
            return self._no_callback() or _NOT_ACCEPTED
        self._until(future.done, _WHOLE_MOVE)
        return self._ended(future)

    def _ended(self, future: Any) -> str:
        """What is wrong with the end of a move whose cancel was accepted."""
        if not future.done():
            busy = self._asker.busy(self._nodes)
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

    def _no_callback(self) -> str:
        """The line that lacks a cancel_callback."""
        for hosted in self._nodes:
            found = hosted.file.source.action_server() if hosted.file is not None else None
            if found is not None and not found[1]:
                return (
                    f"{hosted.file}:{found[0]}: ActionServer has no cancel_callback, and rclpy "
                    "rejects every cancel without one: one that returns CancelResponse.ACCEPT"
                )
        return ""


def _blocked(busy: str) -> str:
    where = f"{busy}: " if busy else ""
    return (
        f"{where}while execute sleeps, a single-threaded executor takes no cancel: spin with a "
        "MultiThreadedExecutor in main(), or await a future"
    )


def _listed(way: Sequence[float]) -> str:
    return ", ".join(f"{distance:g}" for distance in way) or "empty"
