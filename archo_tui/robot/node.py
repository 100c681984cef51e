"""The node of the console: what it hears, the services that it calls, and its timers."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.context import Context
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.task import Future

from archo_tui.robot.messages.types import element_of
from archo_tui.robot.stop.gate import Gate

LATE = 20.0  # Seconds in which a late answer to a STOP is still received.
DEADLINE = 2.0  # Seconds for an answer.
QUESTION_TIMEOUT = 2 * DEADLINE  # Seconds for a question that the ROS thread asks a node.

# Gets the full name of a topic, the message class, and a message as CDR.
MessageCallback = Callable[[str, Any, bytes], None]


def require_all_answers(
    future: Any, servers: int, good: Callable[[Any], bool] = lambda _: False
) -> list[Any]:
    """Change a call's future so that it ends with all servers' answers, or with a good one."""
    finish = future.set_result
    answers: list[Any] = []

    def take(answer: Any) -> None:
        answers.append(answer)
        if len(answers) >= servers or good(answer):
            finish(answer)

    future.set_result = take
    return answers


class ConsoleNode(Node):
    """A node that passes each message to `on_message`, before the callback of its subscription.

    Its timers and deadlines go by a steady clock: the robot's time may jump. ROS thread only.
    """

    def __init__(
        self,
        name: str,
        context: Context,
        on_message: MessageCallback,
        masks: Mapping[Any, Callable[[Any], Any]],
    ) -> None:
        super().__init__(name, context=context, start_parameter_services=False)
        self._on_message, self._masks = on_message, masks
        self._steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self._kept_clients: dict[tuple[str, Any], Any] = {}
        self._awaited: list[Any] = []  # The clients whose calls wait, one for each call.
        self._turns = itertools.count(1)
        # Called with the turn of an operator's request when it is answered, however late: a release
        # that is carried out late undoes a later STOP.
        self.on_answered: Callable[[int], None] = lambda _: None

    def listen_quietly(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> Any:
        """Subscribe to a topic; nothing is logged about an incompatible QoS.

        rclpy checks the event handlers that log at each wake-up.
        """
        name, mask = self.resolve_topic_name(topic), self._masks.get(kind)

        def on_data(data: bytes) -> None:
            message = deserialize_message(data, kind)
            shown = message if mask is None else mask(message)
            self._on_message(name, kind, data if shown is message else serialize(shown))
            callback(message)

        return self.listen_raw(kind, topic, on_data, qos)

    def listen_raw(
        self, kind: Any, topic: str, callback: Callable[[bytes], None], qos: QoSProfile | int
    ) -> Any:
        """Subscribe to a topic for messages as bytes, which `on_message` does not get."""
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self.create_subscription(kind, topic, callback, qos, event_callbacks=quiet, raw=True)

    def without_secrets(self, message: Any) -> Any:
        """Return a message as `on_message` would get it: with secret values masked. Any thread."""
        mask = self._masks.get(type(message))
        return message if mask is None else mask(message)

    def create_steady_timer(self, seconds: float, callback: Callable[[], Any]) -> Any:
        """Create a timer that goes by real time."""
        return self.create_timer(seconds, callback, clock=self._steady)

    def wake_executor(self) -> None:
        """Have the executor go on with tasks whose futures are done."""
        if self.executor is not None:
            self.executor.wake()

    def client(self, srv_type: Any, name: str) -> Any:
        """Return the client of a service, which is kept until `destroy_clients`."""
        key = (name, srv_type)
        if key not in self._kept_clients:
            self._kept_clients[key] = self.create_client(srv_type, name)
        return self._kept_clients[key]

    def destroy_clients(self, node: str) -> None:
        """Destroy the clients of the services below a node's name, as of a node that has left."""
        for key in [key for key in self._kept_clients if key[0].startswith(f"{node}/")]:
            self.destroy_client(self._kept_clients.pop(key))

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

        A request with a gate is an operator's: its turn is passed to `on_answered` however
        late, and an answer after `wait` to `late`. Raises Void if the gate is shut.
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

            return future.result() if await self.in_time(future, wait, on_end) else None
        self.cancel_at_deadline(future, client)
        self._awaited.append(client)
        answer = await future
        self._awaited.remove(client)
        key = (name, srv_type)
        is_kept = self._kept_clients.get(key) is client
        if once and answer is not None and is_kept and client not in self._awaited:
            self.destroy_client(self._kept_clients.pop(key))
        return answer

    def next_turn(self) -> int:
        """Take and return the next number in the order in which requests leave; the first is 1."""
        return next(self._turns)

    async def in_time(self, future: Any, wait: float, on_end: Callable[[bool], None]) -> bool:
        """Wait for the end of a call; return True if it came within `wait`."""
        in_time: Future[bool] = Future(executor=self.executor)

        def on_answer(done: Any) -> None:
            if done.cancelled():
                return
            is_late = in_time.cancelled()
            in_time.set_result(True)
            on_end(is_late)
            self.wake_executor()

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
        await self.in_time(future, wait, on_end)
        return list(answers)

    def cancel_at_deadline(self, future: Any, client: Any = None, wait: float = DEADLINE) -> None:
        """Cancel a future after a time, unless it is done; whoever awaits it gets None."""

        def expire() -> None:
            if client is not None:
                client.remove_pending_request(future)
            future.cancel()

        timer = self.create_steady_timer(wait, expire)
        future.add_done_callback(lambda _: self.destroy_timer(timer))

    async def pause(self, seconds: float) -> None:
        """Wait for a number of real seconds, on the ROS thread without blocking it."""
        passed: Future[bool] = Future(executor=self.executor)
        timer = self.create_steady_timer(seconds, lambda: passed.set_result(True))
        await passed
        self.destroy_timer(timer)


# The serialize_message of Jazzy returns as many bytes as it had estimated, the last of which are
# whatever lay in that memory. Readers refuse a message with more bytes than its fields have. Sizes
# and alignment are those of XCDR version 1, as OMG's DDS-XTypes 1.3 defines it in 7.4.

_PRIMITIVE_SIZES = {
    "boolean": 1, "octet": 1, "char": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2,
    "int32": 4, "uint32": 4, "float": 4, "int64": 8, "uint64": 8, "double": 8,
}  # fmt: skip
_ENCAPSULATION = 4  # Bytes of the header; offsets are counted from behind it.


def serialize(message: Any) -> bytes:
    """Return a message as CDR, and no more."""
    return serialize_message(message)[: cdr_size(message)]


def cdr_size(message: Any) -> int:
    """Return the number of bytes of a message as CDR, with the 4 of the encapsulation header."""
    return _ENCAPSULATION + _message_end(message, 0)


def _message_end(message: Any, offset: int) -> int:
    fields = message.get_fields_and_field_types()
    for name, kind in fields.items():
        offset = _field_end(kind, getattr(message, name), offset)
    return offset if fields else offset + 1  # rosidl gives an empty message a dummy byte.


def _field_end(kind: str, value: Any, offset: int) -> int:
    element = element_of(kind)
    if element is None:
        return _value_end(kind, value, offset)
    if kind.startswith("sequence<"):
        offset = _align(offset, 4) + 4  # Its length.
    size = _PRIMITIVE_SIZES.get(element)
    if size is not None:
        return _align(offset, size) + size * len(value) if len(value) else offset
    for item in value:
        offset = _value_end(element, item, offset)
    return offset


def _value_end(kind: str, value: Any, offset: int) -> int:
    if kind.partition("<")[0] == "string":
        return _align(offset, 4) + 4 + len(value.encode()) + 1
    if kind.partition("<")[0] == "wstring":
        return _align(offset, 4) + 4 + 2 * len(value.encode("utf-16-le"))  # Four bytes a code unit.
    if kind in _PRIMITIVE_SIZES:
        return _align(offset, _PRIMITIVE_SIZES[kind]) + _PRIMITIVE_SIZES[kind]
    return _message_end(value, offset)


def _align(offset: int, size: int) -> int:
    return offset + -offset % size
