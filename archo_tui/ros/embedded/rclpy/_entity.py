"""The bases of what an executor gets work from: subscriptions, clients, services and timers."""

from __future__ import annotations

import inspect
import uuid
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy._rclpy_pybind11 import InvalidHandle
from rclpy.callback_groups import CallbackGroup

if TYPE_CHECKING:
    from rclpy.event_handler import EventHandler
    from rclpy.node import Node
    from rclpy.qos import QoSProfile


DestroyableT = TypeVar("DestroyableT", bound="Destroyable")


class Destroyable:
    """The base of objects that can be destroyed; using a destroyed one raises InvalidHandle.

    Leaving a `with` destroys the object.
    """

    _destroyed = False
    _is_part_of_action = False  # Then the node does not list it.
    _node: Node

    @property
    def logger_name(self) -> str:
        """Return the name of the node's logger."""
        return self._node.get_logger().name

    def destroy(self) -> None:
        """Leave the graph, and start no further callback; one that runs goes on.

        The node still lists the object, unlike after the node's own `destroy_...`.
        """
        self._destroyed = True

    def __enter__(self: DestroyableT) -> DestroyableT:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()

    def _use(self) -> None:
        """Raise InvalidHandle if the object has been destroyed."""
        if self._destroyed:
            raise InvalidHandle("cannot use Destroyable because destruction was requested")


class Endpoint(Destroyable):
    """The base of publishers and subscriptions, with the handlers of their events."""

    event_handlers: Sequence[EventHandler] = ()

    def __init__(
        self, node: Node, msg_type: Any, topic: str, topic_name: str, qos_profile: QoSProfile
    ) -> None:
        self._node, self.msg_type, self.qos_profile = node, msg_type, qos_profile
        self.topic, self._topic_name = topic, topic_name  # As given, and as on the graph.
        self._gid = list(uuid.uuid4().bytes)

    @property
    def topic_name(self) -> str:
        """Return the topic's name on the graph; raise InvalidHandle after `destroy()`."""
        self._use()
        return self._topic_name

    def destroy(self) -> None:
        super().destroy()
        for handler in self.event_handlers:
            handler.destroy()


class Entity(Destroyable):
    """The base of what gives an executor work: timers, subscriptions, clients, services, events."""

    # The order in a round: actions, timers, subscriptions, clients, services.
    _rank = 1
    callback: Any = None

    def __init__(self, node: Node, callback_group: CallbackGroup) -> None:
        self._node = node
        self.callback_group = callback_group

    def _take(self) -> Callable[[], Any] | None:
        """Take the next piece of work off, and return it as a function; return None without work.

        The function may return a coroutine: see `_is_awaited`.
        """
        raise NotImplementedError

    def _is_awaited(self) -> bool:
        """Return True if the callback is an `async def`: the executor then awaits its coroutine."""
        return inspect.iscoroutinefunction(self.callback)

    def _waiting(self) -> int:
        """Return the number of pieces of work that wait to be taken."""
        return 0

    def _notify(self) -> None:
        """Tell the node's executor that this entity has work.

        Without an executor nothing happens: the work waits until the node is added to one.
        """
        executor = self._node._executor
        if executor is not None:
            executor._make_ready(self)


class QueueEntity(Entity):
    """An entity with a queue of received items; a full queue drops its oldest item.

    Its executor takes one item a round, so that no full queue keeps another entity waiting. A
    `size` of None means no bound. An item that comes after `destroy()` is dropped.
    """

    def __init__(self, node: Node, callback_group: CallbackGroup, size: int | None) -> None:
        super().__init__(node, callback_group)
        self._queue: deque[Any] = deque(maxlen=size)  # append and popleft are thread-safe.

    def _deliver(self, item: Any) -> None:
        if not self._destroyed:
            self._queue.append(item)
            self._notify()

    def _take(self) -> Callable[[], Any] | None:
        try:
            item = self._queue.popleft()
        except IndexError:
            return None
        return None if self._destroyed else self._work(item)

    def _work(self, item: Any) -> Callable[[], Any]:
        """Return the function that an executor calls for an item."""
        return partial(self._handle, item)

    def _handle(self, item: Any) -> Any:
        raise NotImplementedError

    def _waiting(self) -> int:
        return 0 if self._destroyed else len(self._queue)


class ServiceEnd(QueueEntity):
    """The base of a service's client and server; `table` is the graph's, in which it is listed."""

    def __init__(
        self,
        node: Node,
        srv_type: Any,
        srv_name: str,
        service_name: str,
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
        table: dict[str, list[Any]],
    ) -> None:
        super().__init__(node, callback_group, qos_profile._queue_size)
        self.srv_type, self.qos_profile, self._table = srv_type, qos_profile, table
        self.srv_name, self._service_name = srv_name, service_name  # As given, on the graph.

    @property
    def service_name(self) -> str:
        """Return the service's name on the graph; raise InvalidHandle after `destroy()`."""
        self._use()
        return self._service_name

    def destroy(self) -> None:
        super().destroy()
        self._node._graph.remove_named(self._table, self._service_name, self)
