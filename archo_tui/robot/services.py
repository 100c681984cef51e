"""Service calls that always end: answered, or given up at their deadline. ROS thread only."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.clock import Clock
from archo_tui.robot.stops import Gate

LATE = 20.0  # s that a late answer to a STOP is heard of
MOST_UNANSWERED = 1000  # requests of an operator whose answers are still heard of, however late
DEADLINE = 2.0  # s; "no answer in 2 s"
_EARLY = 1e-3  # s that a timer may fire before its time and still count


def hold_open(
    future: Any, servers: int, good: Callable[[Any], bool] = lambda _: False
) -> list[Any]:
    """End a call that reaches several servers with the first good answer, or with the last one.

    rclpy would take the first, which may come from a server that does not know the goal.
    Returns all the answers, in a list that fills as they come.
    """
    finish = future.set_result
    answers: list[Any] = []

    def take(answer: Any) -> None:
        answers.append(answer)
        if len(answers) >= servers or good(answer):
            finish(answer)

    future.set_result = take
    return answers


class Services:
    """Makes clients as they are needed and keeps track of what is pending."""

    def __init__(self, node: Node, clock: Clock) -> None:
        self._node, self._clock = node, clock
        self._clients: dict[tuple[str, Any], Any] = {}
        self._pending: list[tuple[float, int, Any, Any]] = []  # a heap: the next deadline first
        # of what an operator sent, by turn: a release that is answered late undoes a later STOP
        self._unanswered: dict[int, tuple[Any, Any]] = {}
        self._steady = RosClock(clock_type=ClockType.STEADY_TIME)  # whatever the robot's time does
        self._timer = node.create_timer(DEADLINE, self._sweep, clock=self._steady)
        self._timer.cancel()
        self._turns = itertools.count(1)
        # called with the turn of a request that somebody typed when it is answered, however late
        self.answered: Callable[[int], None] = lambda _: None

    @property
    def pending(self) -> int:
        """How many answers are waited for."""
        return len(self._pending)

    def client(self, srv_type: Any, name: str) -> Any:
        """The client of that service."""
        key = (name, srv_type)
        if key not in self._clients:
            self._clients[key] = self._node.create_client(srv_type, name)
        return self._clients[key]

    def forget(self, node: str) -> None:
        """That node has left: its services need no clients any more."""
        for key in [key for key in self._clients if key[0].startswith(f"{node}/")]:
            self._node.destroy_client(self._clients.pop(key))

    async def call(
        self,
        srv_type: Any,
        name: str,
        request: Any,
        *,
        once: bool = False,
        gate: Gate | None = None,
        wait: float = DEADLINE,
        late: Callable[[Any], None] = lambda _: None,
    ) -> Any:
        """The response, or None when nobody answered within `wait` s.

        `gate` is passed last, as the request leaves: it raises where that is not to be sent.
        Of a request with a gate an answer that comes later is heard of, too: `answered`, and
        `late(answer)`. Without a gate DEADLINE holds.

        The client of a call that is made once is not kept: rclpy looks at each, whatever comes. It
        stays where nobody answered: a server that answers late finds its client.
        """
        client = self.client(srv_type, name)
        if gate is not None:
            gate()
        turn = self.turn()
        future = client.call_async(request)
        if gate is not None:
            self._hear_however_late(turn, future, client)

            def told(is_late: bool) -> None:
                self.answered(turn)
                if is_late:
                    late(future.result())

            return future.result() if await self._in_time(future, wait, told) else None
        self.watch(future, client)
        answer = await future
        if once and answer is not None and self._clients.pop((name, srv_type), None) is not None:
            self._node.destroy_client(client)
        return answer

    def _hear_however_late(self, turn: int, future: Any, client: Any) -> None:
        """Keep a request until it is answered; of too many the oldest is given up."""
        self._unanswered[turn] = future, client
        future.add_done_callback(lambda _: self._unanswered.pop(turn, None))
        if len(self._unanswered) > MOST_UNANSWERED:
            oldest, its_client = self._unanswered.pop(next(iter(self._unanswered)))
            its_client.remove_pending_request(oldest)
            oldest.cancel()

    def turn(self) -> int:
        """The next number in the order in which requests leave."""
        return next(self._turns)

    async def _in_time(self, future: Any, wait: float, told: Callable[[bool], None]) -> bool:
        """Return True when the call ends within `wait` s.

        `told(is_late)` is called when it ends.
        """
        in_time: Future[bool] = Future(executor=self._node.executor)

        def on_answer(done: Any) -> None:
            if done.cancelled():
                return
            is_late = in_time.cancelled()
            in_time.set_result(True)
            told(is_late)
            if self._node.executor is not None:
                self._node.executor.wake()

        future.add_done_callback(on_answer)
        self.watch(in_time, wait=wait)
        return bool(await in_time)

    async def call_all(
        self,
        srv_type: Any,
        name: str,
        request: Any,
        servers: int,
        wait: float,
        late: Callable[[list[Any]], None] = lambda _: None,
    ) -> list[Any]:
        """What so many servers of one name answered to one call within `wait` s.

        `late(answers)` is called when the last of them comes after that, within LATE.
        """
        client = self.client(srv_type, name)
        future = client.call_async(request)
        answers = hold_open(future, servers)
        told = lambda is_late: late(answers) if is_late else None  # noqa: E731
        self.watch(future, client, LATE)
        await self._in_time(future, wait, told)
        return list(answers)

    def watch(self, future: Any, client: Any = None, wait: float = DEADLINE) -> None:
        """Cancel the future when its deadline (s) passes: awaiting it then gives None."""
        deadline = self._clock.monotonic() + wait
        heapq.heappush(self._pending, (deadline, self.turn(), future, client))
        if self._timer.is_canceled() or self._pending[0][0] == deadline:
            self._wake_after(wait)

    async def pause(self, seconds: float) -> None:
        """Let that many seconds pass."""
        passed: Future[bool] = Future(executor=self._node.executor)
        timer = self._node.create_timer(
            seconds, lambda: passed.set_result(True), clock=self._steady
        )
        await passed
        self._node.destroy_timer(timer)

    def _sweep(self) -> None:
        now = self._clock.monotonic()
        while self._pending:
            deadline, _, future, client = self._pending[0]
            if not (future.done() or future.cancelled()):
                if deadline > now + _EARLY:
                    self._wake_after(deadline - now)
                    return
                if client is not None:
                    client.remove_pending_request(future)
                future.cancel()
            heapq.heappop(self._pending)
        self._timer.cancel()

    def _wake_after(self, seconds: float) -> None:
        self._timer.timer_period_ns = int(seconds * 1e9)
        self._timer.reset()
