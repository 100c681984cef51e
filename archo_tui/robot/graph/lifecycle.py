"""The states of managed nodes (those of rclcpp_lifecycle and rclpy.lifecycle). ROS thread only."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState

from archo_tui.base.safe_text import harmless
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.runtime import Runtime
from archo_tui.robot.state.graph import NodeState
from archo_tui.robot.stop.gate import Gate

_GET_STATE = "/get_state"
_TYPE = "lifecycle_msgs/srv/GetState"
# Seconds after which a node is asked again: it may send no events, or one was lost.
_ASK_AGAIN = 10.0
# Seconds for a transition: what a node does in `on_configure` may take long.
CHANGE_TIMEOUT = 30.0
_NO_ANSWER = "no answer"


class _Managed:
    """A managed node, as far as it is known."""

    word = ""  # Its state; "" until it has answered.
    is_silent = False  # It left the last question unanswered.
    subscription: Any = None

    def __init__(self, asked: float) -> None:
        self.asked = asked  # When it was asked last, in monotonic seconds.

    @property
    def shown(self) -> str:
        return ", ".join(filter(None, (self.word, _NO_ANSWER if self.is_silent else "")))


class Lifecycles:
    """The state of each managed node: requested when it comes, then told by its events."""

    def __init__(self, runtime: Runtime) -> None:
        self._node, self._clock = runtime.node, runtime.clock
        self._submit, self._on_change = runtime.thread.submit, runtime.snapshots.send_soon
        self._managed: dict[str, _Managed] = {}  # By full name of the node.

    def poll(self, served: Mapping[str, Sequence[str]]) -> None:
        """Follow the managed nodes that are on the graph now, and forget those that have left."""
        found = {
            name.removesuffix(_GET_STATE)
            for name, types in served.items()
            if name.endswith(_GET_STATE) and _TYPE in types
        }
        for node in self._managed.keys() - found:
            left = self._managed.pop(node)
            if left.subscription is not None:
                self._node.destroy_subscription(left.subscription)
            self._on_change()
        now = self._clock.monotonic()
        for node in found - self._managed.keys():
            self._managed[node] = managed = _Managed(-math.inf)
            # If this fails, as for a topic of another type, it is asked again each _ASK_AGAIN.
            with contextlib.suppress(Exception):
                managed.subscription = self._node.listen_quietly(
                    TransitionEvent, f"{node}/transition_event", self._handler(node), 10
                )
        for node, managed in self._managed.items():
            if now - managed.asked >= _ASK_AGAIN:
                managed.asked = now
                self._submit(partial(self._ask, node))

    def with_states(self, nodes: Sequence[NodeState]) -> tuple[NodeState, ...]:
        """Return nodes with the `lifecycle` of those that are managed; others stay as they are."""
        known = self._managed
        return tuple(
            node._replace(lifecycle=known[node.name].shown) if node.name in known else node
            for node in nodes
        )

    def word(self, node: str) -> str:
        """Return the last known state of a node: `active`; "" if none is known."""
        return self._managed[node].word if node in self._managed else ""

    async def transitions(self, node: str) -> tuple[str, ...]:
        """Ask a node which transitions it can make now, as words: `activate`."""
        return tuple(harmless(found.label) for found in await self._available(node) or ())

    async def change(
        self, node: str, word: str, gate: Gate, late: Callable[[Outcome], None]
    ) -> Outcome:
        """Request a transition, wait for its end, and ask for the new state; Void behind a STOP."""
        if node not in self._managed:
            return Outcome(Code.NOT_OFFERED, f"{node} is not a managed node")
        available = await self._available(node)
        if available is None:
            return Outcome(Code.TIMEOUT, f"no answer in {DEADLINE:g} s from {node}")
        found = next((transition for transition in available if transition.label == word), None)
        if found is None:
            words = ", ".join(dict.fromkeys(transition.label for transition in available)) or "none"
            state = self.word(node) or "this state"
            return Outcome(Code.REFUSED, f"not possible in {state}: there are {words}")
        request = ChangeState.Request(transition=Transition(id=found.id, label=found.label))
        answer = await self._node.call(
            ChangeState,
            f"{node}/change_state",
            request,
            gate=gate,
            wait=CHANGE_TIMEOUT,
            late=lambda answer: late(self._outcome(node, answer)),
        )
        await self._ask(node)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {CHANGE_TIMEOUT:g} s: it may still do it")
        return self._outcome(node, answer)

    def _outcome(self, node: str, answer: Any) -> Outcome:
        state = self.word(node) or "unknown"
        if answer.success:
            return Outcome(Code.DONE, f"{node.lstrip('/')} is {state}")
        return Outcome(Code.REFUSED, f"{node.lstrip('/')} rejected it, and is {state}")

    def _handler(self, node: str) -> Callable[[Any], None]:
        return lambda message: self._set(node, harmless(message.goal_state.label))

    async def _ask(self, node: str) -> None:
        answer = await self._node.call(GetState, f"{node}{_GET_STATE}", GetState.Request())
        if answer is not None:
            self._set(node, harmless(answer.current_state.label))
        elif node in self._managed and not self._managed[node].is_silent:
            self._managed[node].is_silent = True
            self._on_change()

    async def _available(self, node: str) -> list[Any] | None:
        """Ask a node for the transitions that it can make now; None if it does not answer."""
        name = f"{node}/get_available_transitions"
        answer = await self._node.call(
            GetAvailableTransitions, name, GetAvailableTransitions.Request(), once=True
        )
        if answer is None:
            return None
        return [description.transition for description in answer.available_transitions]

    def _set(self, node: str, word: str) -> None:
        managed = self._managed.get(node)
        if managed is not None and (managed.word != word or managed.is_silent):
            managed.word, managed.is_silent = word, False
            self._on_change()
