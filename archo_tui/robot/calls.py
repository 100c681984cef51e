"""Service calls with deadlines. ROS thread only."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.robot.stop.gate import Gate

LATE = 20.0  # Seconds in which a late answer to a STOP is still received.
DEADLINE = 2.0  # Seconds for an answer.
QUESTION_TIMEOUT = 2 * DEADLINE  # Seconds for a question that the ROS thread asks a node.


def require_all_answers(
    future: Any, servers: int, good: Callable[[Any], bool] = lambda _: False
) -> list[Any]:
    """Change a call's future so that it ends with the answers of all servers, or with a good one.

    rclpy would end it with the first answer, perhaps of a server that does not know the goal. The
    result of the future is the answer that ended it.
    """
    finish = future.set_result
    answers: list[Any] = []

    def take(answer: Any) -> None:
        answers.append(answer)
        if len(answers) >= servers or good(answer):
            finish(answer)

    future.set_result = take
    return answers


def wake(node: Node) -> None:
    """Wake the executor of a node, so that it goes on with tasks whose futures are done."""
    if node.executor is not None:
        node.executor.wake()


class Services:
    """The service clients of a node, and the calls that wait for answers."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[tuple[str, Any], Any] = {}
        self._awaited: list[Any] = []  # The clients whose calls wait, one for each call.
        self.steady = RosClock(clock_type=ClockType.STEADY_TIME)  # The robot's time may jump.
        self._turns = itertools.count(1)
        # Called with the turn of an operator's request when it is answered, however late: a release
        # that is carried out late undoes a later STOP.
        self.on_answered: Callable[[int], None] = lambda _: None

    def client(self, srv_type: Any, name: str) -> Any:
        """Return the client of a service, which is kept until `destroy_clients`."""
        key = (name, srv_type)
        if key not in self._clients:
            self._clients[key] = self._node.create_client(srv_type, name)
        return self._clients[key]

    def destroy_clients(self, node: str) -> None:
        """Destroy the clients of the services below a node's name, as of a node that has left."""
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
        """Call a service; return the answer, or None if there was none in time.

        A request with a gate is an operator's: its answer is received however late, its turn is
        passed to `on_answered`, and an answer after `wait` to `late`.

        Raises:
            Void: The gate is shut: a STOP was read after the request was typed.
        """
        client = self.client(srv_type, name)
        if gate is not None:
            gate()
        turn = self.next_turn()
        future = client.call_async(request)
        if gate is not None:

            def on_end(is_late: bool) -> None:
                self.on_answered(turn)
                if is_late:
                    late(future.result())

            return future.result() if await self._in_time(future, wait, on_end) else None
        self.cancel_at_deadline(future, client)
        self._awaited.append(client)
        answer = await future
        self._awaited.remove(client)
        key = (name, srv_type)
        is_kept = self._clients.get(key) is client
        if once and answer is not None and is_kept and client not in self._awaited:
            self._node.destroy_client(self._clients.pop(key))
        return answer

    def next_turn(self) -> int:
        """Take and return the next number in the order in which requests leave; the first is 1."""
        return next(self._turns)

    async def _in_time(self, future: Any, wait: float, on_end: Callable[[bool], None]) -> bool:
        """Wait for the end of a call; return True if it came within `wait`."""
        in_time: Future[bool] = Future(executor=self._node.executor)

        def on_answer(done: Any) -> None:
            if done.cancelled():
                return
            is_late = in_time.cancelled()
            in_time.set_result(True)
            on_end(is_late)
            wake(self._node)

        future.add_done_callback(on_answer)
        self.cancel_at_deadline(in_time, wait=wait)
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
        """Call a service that several servers offer; return the answers that came in time."""
        client = self.client(srv_type, name)
        future = client.call_async(request)
        answers = require_all_answers(future, servers)
        on_end = lambda is_late: late(answers) if is_late else None  # noqa: E731
        self.cancel_at_deadline(future, client, LATE)
        await self._in_time(future, wait, on_end)
        return list(answers)

    def cancel_at_deadline(self, future: Any, client: Any = None, wait: float = DEADLINE) -> None:
        """Cancel a future after a time, unless it is done; whoever awaits it gets None."""

        def expire() -> None:
            if client is not None:
                client.remove_pending_request(future)
            future.cancel()

        timer = self._node.create_timer(wait, expire, clock=self.steady)
        future.add_done_callback(lambda _: self._node.destroy_timer(timer))

    async def pause(self, seconds: float) -> None:
        """Wait for a number of real seconds, on the ROS thread without blocking it."""
        passed: Future[bool] = Future(executor=self._node.executor)
        timer = self._node.create_timer(seconds, lambda: passed.set_result(True), clock=self.steady)
        await passed
        self._node.destroy_timer(timer)
