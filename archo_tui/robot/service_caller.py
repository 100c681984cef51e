"""Calls of services: those of the robot file, and any other. ROS thread only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.clock import Clock as RosClock
from rclpy.node import Node

from archo_tui.robot import calls
from archo_tui.robot.calls import Services
from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.graph.interface_checks import InterfaceChecks
from archo_tui.robot.messages.text import one_line
from archo_tui.robot.messages.values import filled
from archo_tui.robot.outcome import SLOW_CALL, Answer, Code, Outcome, outcome_of, says_more
from archo_tui.robot.state import not_offered
from archo_tui.robot.stop.gate import Gate


class ServiceCaller:
    """A caller of services, which turns each answer into an outcome."""

    def __init__(
        self,
        node: Node,
        clock: RosClock,
        pending: Services,
        graph: Graph,
        checks: InterfaceChecks,
    ) -> None:
        self._node, self._clock, self._services = node, clock, pending
        self._graph, self._checks = graph, checks

    async def call_named(
        self,
        name: str,
        fields: Mapping[str, Any],
        gate: Gate,
        late: Callable[[Outcome], None],
    ) -> Outcome:
        """Call a service of the robot file with the type of its server, if the request fits it.

        Raises:
            Void: The gate is shut: a STOP was read in the meantime.
        """
        if name not in self._graph.offered:
            return Outcome(Code.NOT_OFFERED, not_offered(self._checks.full(name)))
        srv_type, reason = self._checks.fitting_class(name, fields)
        if srv_type is None:
            return Outcome(Code.REFUSED, reason)
        try:
            request = filled(srv_type.Request(), fields)
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))
        answer = await self._services.call(
            srv_type, name, request, gate=gate, late=lambda answer: late(_outcome_of(answer))
        )
        if answer is None:
            text = f"no answer in {calls.DEADLINE:g} s: the robot may still do it"
            return Outcome(Code.TIMEOUT, text)
        return _outcome_of(answer)

    async def call_any(
        self,
        srv_type: Any,
        name: str,
        request: Any,
        gate: Gate,
        wait: float,
        on_slow: Callable[[], None],
        late: Callable[[Outcome], None],
    ) -> Outcome:
        """Call a service of any type, whether or not a server is known.

        Raises:
            Void: The gate is shut: a STOP was read in the meantime.
        """

        def on_timer() -> None:
            slow.cancel()  # Once.
            on_slow()

        slow = self._node.create_timer(SLOW_CALL, on_timer, clock=self._clock)
        try:
            answer = await self._services.call(
                srv_type,
                name,
                request,
                gate=gate,
                wait=wait,
                late=lambda answer: late(_outcome_with_all_fields(answer)),
            )
        finally:
            self._node.destroy_timer(slow)
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {wait:g} s: the robot may still do it")
        return _outcome_with_all_fields(answer)


def _outcome_of(answer: Any) -> Answer:
    """Return what an answer means, with the answer.

    The text has all fields of the answer if there are more than a verdict and a message.
    """
    outcome = outcome_of(answer)
    more = one_line(answer) if says_more(answer) else ""
    if more and outcome.code is Code.NOT_CONFIRMED:
        more = f"{outcome.text}: {more}"
    return Answer.of(outcome._replace(text=more or outcome.text), answer)


def _outcome_with_all_fields(answer: Any) -> Answer:
    """Return the outcome of an answer, with the answer and a text of all its fields.

    REFUSED only if a field `success` is false.
    """
    text = one_line(answer) or outcome_of(answer).text
    code = Code.DONE if getattr(answer, "success", True) else Code.REFUSED
    return Answer.of(Outcome(code, text), answer)
