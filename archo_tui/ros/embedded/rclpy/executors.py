"""Executors, which run the callbacks of their nodes while somebody spins them.

As with rclpy's wait set, work is done in rounds: the tasks first, then one piece of work of each
entity that is ready by then, timers before subscriptions before clients before services. So a task,
and a service's answer, never wait behind a queue full of messages.
Waiting costs nothing: a heap of timers, one condition variable.
"""

from __future__ import annotations

import heapq
import inspect
import itertools
import os
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future as PoolFuture
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from operator import attrgetter
from types import CoroutineType
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy import _process, _time_source
from rclpy._entity import Entity
from rclpy.context import Context
from rclpy.task import Future, Task
from rclpy.timer import Timer
from rclpy.utilities import get_default_context

if TYPE_CHECKING:
    from rclpy.node import Node


Work = Callable[[], Any]  # A task, or what an entity wants called.
ExecutorT = TypeVar("ExecutorT", bound="Executor")
_KIND = attrgetter("_rank")
Ready = tuple[Task[Any], "Entity | None", "Node | None"]  # What to call, its entity and its node.


async def await_or_execute(callback: Callable[..., Any], *args: Any) -> Any:
    """Return the value of calling a function, or for an `async def` that of its coroutine."""
    if inspect.iscoroutinefunction(callback):
        return await callback(*args)
    return callback(*args)


def _never() -> bool:
    return False


class TimeoutException(Exception):
    """The error for a wait in which nothing became ready in time."""


class ShutdownException(Exception):
    """The error for a wait on an executor that is shut down."""


class ExternalShutdownException(Exception):
    """The error for spinning an executor whose context is shut down."""


class ConditionReachedException(Exception):
    """The error for a wait whose condition was fulfilled before there was anything to call."""


class Executor:
    """The base of executors, which collects work and hands it out piece by piece.

    A user's own executor defines `spin_once`, using `wait_for_ready_callbacks`. The constructor
    raises RuntimeError for a context that has not begun, or has ended. Leaving a `with` shuts the
    executor down.
    """

    _is_concurrent = False  # True if several threads run callbacks.

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = get_default_context() if context is None else context
        if not self._context.ok():
            raise RuntimeError("Context must be initialized before an executor can be created")
        self._nodes: dict[Node, int] = {}  # With its place in the order of adding.
        self._lock = threading.RLock()
        self._condition = threading.Condition(self._lock)
        self._tasks: deque[Task[Any]] = deque()
        self._ready: dict[Entity, None] = {}  # In the order in which they became ready.
        self._round: deque[Entity | Task[Any]] = deque()  # The rest of the current round.
        self._blocked: list[Entity] = []  # Ready, but their callback group is taken.
        self._timers: list[tuple[int, int, Timer]] = []
        self._due_ns: int | None = None  # When the next timer is due; known if no work is left.
        self._order = itertools.count()
        self._is_shutdown = False
        self._had_tasks = False  # True if the round's tasks are done and its entities come next.
        self._notified = False  # True once all waiting threads have been woken.
        self._context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """Return the context whose shutdown ends the spinning."""
        return self._context

    def add_node(self, node: Node) -> bool:
        """Run this node's callbacks, also waiting ones; return False if it was added before.

        The node leaves the executor that it had before.
        """
        _process.current().spin_node(node, self)
        with self._condition:
            if node in self._nodes:
                return False
            self._nodes[node] = next(self._order)
            node.executor = self
            for entity in node._entities():
                if isinstance(entity, Timer):
                    entity._schedule()
                if entity._waiting():
                    self._make_ready(entity)
            self._notify()
            return True

    def remove_node(self, node: Node) -> None:
        """Stop running this node's callbacks.

        `node.executor` stays as it is. A node that was not added is ignored.
        """
        with self._condition:
            if node in self._nodes:
                del self._nodes[node]
                self._drop_work(node)

    def _drop_work(self, node: Node) -> None:
        """Forget a node's timers and that its entities are ready; their queues stay as they are."""
        with self._condition:
            self._timers = [entry for entry in self._timers if entry[2]._node is not node]
            heapq.heapify(self._timers)
            self._ready = {e: None for e in self._ready if e._node is not node}
            kept = [e for e in self._round if isinstance(e, Task) or e._node is not node]
            self._round = deque(kept)
            self._blocked = [e for e in self._blocked if e._node is not node]

    def get_nodes(self) -> list[Node]:
        """Return the nodes in the order in which they were added."""
        return list(self._nodes)

    def create_task(self, callback: Callable[..., Any], *args: Any, **kwargs: Any) -> Task[Any]:
        """Schedule a function or coroutine on this executor, from any thread, and return its task.

        The task runs when the executor is spun.
        """
        task: Task[Any] = Task(callback, args, kwargs, executor=self)
        with self._condition:
            self._tasks.append(task)
            self._notify()
        return task

    def create_future(self) -> Future[Any]:
        """Return a new future whose callbacks run on this executor."""
        return Future(executor=self)

    def wake(self) -> None:
        """Make a waiting spin check for work, from any thread; this alone ends no `spin_once`."""
        with self._condition:
            self._notify()

    def __enter__(self: ExecutorT) -> ExecutorT:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """End all spinning and remove the nodes; return True.

        Callbacks that run are not waited for, so `timeout_sec` has no effect.
        """
        with self._condition:
            self._is_shutdown = True
            for node in list(self._nodes):
                self.remove_node(node)
            self._timers.clear()
            self._notify()
        return True

    def spin(self) -> None:
        """Run callbacks until the executor or the context is shut down, or a callback raises.

        What a callback raises is raised here.
        """
        while self._context.ok() and not self._is_shutdown:
            self.spin_once()

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback or task; return without one when the time is up or at `shutdown()`.

        What the callback raises is raised here.
        """
        raise NotImplementedError

    def can_execute(self, entity: Entity) -> bool:
        """Return True if the entity's group lets its callback start, without claiming the group."""
        return entity.callback_group.can_execute(entity)

    def wait_for_ready_callbacks(self, timeout_sec: float | None = None) -> Ready:
        """Return the next task to call, with its entity and node, for a user's own executor.

        The entity's callback group is taken until the task has been called. Entity and node are
        None for a task of `create_task`.
        """
        work, entity = self._next_work(timeout_sec, _never)
        if entity is None:
            return work, None, None  # type: ignore[return-value]  # a task
        return Task(self._execute, (work, entity), executor=self), entity, entity._node

    def spin_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run callbacks until the future ends, the time is up, or context or executor is shut down.

        A future ends when it is done or cancelled. What a callback raises is raised here.
        """
        deadline = _time_source.deadline_ns(timeout_sec)
        while self._context.ok() and not self._is_shutdown:
            if future.done() or future.cancelled():
                return
            left = None if deadline is None else (deadline - _time_source.monotonic_ns()) / 1e9
            self.spin_once_until_future_complete(future, None if left is None else max(left, 0.0))
            if left is not None and left <= 0:
                return

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run one callback or task; return without one once the future is done or the time is up.

        Unlike in rclpy, work that is ready is run even if the future is done already. What the
        callback raises is raised here.
        """
        raise NotImplementedError

    def _execute(self, work: Work, entity: Entity | None) -> None:
        """Run a piece of work, release its callback group, and raise what the work raises.

        The coroutine of an `async def` becomes a task, which holds the group until it ends.
        """
        if entity is None:
            self._run_task(work)  # type: ignore[arg-type]
        else:
            group = entity.callback_group
            try:
                found = work()
            except BaseException:
                group.ending_execution(entity)
                raise
            if isinstance(found, CoroutineType) and entity._is_awaited():
                task: Task[Any] = Task(found, executor=self)
                task._release = lambda: group.ending_execution(entity)
                self._run_task(task)
            else:
                group.ending_execution(entity)
        if self._blocked or self._is_concurrent:
            with self._condition:
                self._ready.update(dict.fromkeys(self._blocked))
                self._blocked.clear()

    def _run_task(self, task: Task[Any]) -> None:
        task()
        error = task.exception()
        if error is not None:
            raise error

    def _notify(self) -> None:
        """Make a waiting spin check for work; the caller holds the condition."""
        if not self._notified:
            self._notified = True
            self._condition.notify_all()

    def _make_ready(self, entity: Entity) -> None:
        """Queue an entity that has work, and wake a waiting spin.

        An entity whose node has left is ignored.
        """
        with self._lock:
            if entity._node in self._nodes:  # The node may have left meanwhile.
                self._ready[entity] = None
                if not self._notified:
                    self._notify()

    def _resume(self, task: Task[Any]) -> None:
        """Queue a task whose awaited future is done, without waking a waiting spin."""
        with self._condition:
            self._tasks.append(task)

    def _add_timer(self, timer: Timer) -> None:
        with self._condition:
            if timer._node in self._nodes:  # Otherwise it is added with its node.
                heapq.heappush(self._timers, (timer._next_ns, next(self._order), timer))
                self._notify()

    def _next_work(
        self, timeout_sec: float | None, stop: Callable[[], bool]
    ) -> tuple[Work, Entity | None]:
        """Block until there is a piece of work, and take it."""
        deadline = _time_source.deadline_ns(timeout_sec)
        with self._condition:
            while True:
                if self._is_shutdown:
                    raise ShutdownException
                if not self._context._ok:
                    raise ExternalShutdownException
                found = self._pop_ready()
                if found is not None:
                    return found
                if stop():
                    raise ConditionReachedException
                if deadline is not None and _time_source.monotonic_ns() >= deadline:
                    raise TimeoutException
                ends = [end for end in (self._due_ns, deadline) if end is not None]
                self._notified = False
                _time_source.wait(
                    self._condition,
                    lambda: self._is_idle() and not stop(),
                    min(ends, default=None),
                )

    def _is_idle(self) -> bool:
        """Return True until work is announced, so that a wait goes on."""
        return not self._notified

    def _collect_timers(self) -> int | None:
        """Queue the timers that are due, and return when the next one is, or None without one.

        The time is monotonic, in ns.
        """
        while self._timers:
            when, _, timer = self._timers[0]
            if when > _time_source.monotonic_ns():
                return when
            heapq.heappop(self._timers)
            # The timer may count simulated time by now.
            if timer._node.executor is self and timer._is_due():
                self._make_ready(timer)
        return None

    def _pop_ready(self) -> tuple[Work, Entity | None] | None:
        """Take the next piece of work of this round or else of the next, or return None."""
        while True:
            if not self._round:
                self._begin_round()
                if not self._round:
                    return None
            item = self._round.popleft()
            if isinstance(item, Task):
                return item, None
            work = self._take(item)
            if work is not None:
                return work, item

    def _begin_round(self) -> None:
        """Fill the round with all waiting tasks, or with all ready entities and due timers.

        After a round of tasks comes one of entities, if any is ready.
        """
        if self._tasks and not (self._had_tasks and self._ready):
            self._had_tasks = True
            self._round.extend(self._tasks)
            self._tasks.clear()
            return
        self._had_tasks = False
        self._due_ns = self._collect_timers()
        ready, self._ready = self._ready, {}
        if len(ready) > 1:  # By node, then by kind, then by when they became ready.
            key: Any = _KIND if len(self._nodes) == 1 else self._place
            self._round.extend(sorted(ready, key=key))
        else:
            self._round.extend(ready)

    def _place(self, entity: Entity) -> tuple[int, int]:
        return self._nodes[entity._node], entity._rank

    def _take(self, entity: Entity) -> Work | None:
        """Claim an entity's callback group and take a piece of its work.

        None is returned without work, and while the group is taken: then the entity is tried again
        as soon as a callback has ended.
        """
        if not entity.callback_group.beginning_execution(entity):
            if entity._node in self._nodes:
                self._blocked.append(entity)
            return None
        work = entity._take()
        if entity._waiting() and entity._node in self._nodes:  # The node may have left.
            self._ready[entity] = None
        if work is None:
            entity.callback_group.ending_execution(entity)
        return work


class SingleThreadedExecutor(Executor):
    """An executor that runs every callback in the thread that spins."""

    def spin_once(self, timeout_sec: float | None = None) -> None:
        self._spin_once(timeout_sec, _never)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        future._when_done(self.wake)
        self._spin_once(timeout_sec, future.done)

    def _spin_once(self, timeout_sec: float | None, stop: Callable[[], bool]) -> None:
        try:
            work, entity = self._next_work(timeout_sec, stop)
        except (TimeoutException, ShutdownException, ConditionReachedException):
            return
        self._run(work, entity)

    _run = Executor._execute


class MultiThreadedExecutor(SingleThreadedExecutor):
    """An executor with a pool of threads; callback groups say what may run at the same time.

    `spin_once` starts a callback and does not wait for its end: what the callback raises, a later
    `spin_once` raises.
    """

    _is_concurrent = True

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        self._executor = ThreadPoolExecutor(os.cpu_count() if num_threads is None else num_threads)
        self._running: list[PoolFuture[None]] = []

    def _is_idle(self) -> bool:
        return super()._is_idle() and all(future.done() for future in self._running)

    def _spin_once(self, timeout_sec: float | None, stop: Callable[[], bool]) -> None:
        with suppress(ExternalShutdownException):  # `spin` ends silently on shutdown.
            super()._spin_once(timeout_sec, stop)

    def _run(self, work: Work, entity: Entity | None) -> None:
        self._running.append(self._executor.submit(self._execute_and_wake, work, entity))
        for future in [future for future in self._running if future.done()]:
            self._running.remove(future)
            future.result()

    def _execute_and_wake(self, work: Work, entity: Entity | None) -> None:
        try:
            self._execute(work, entity)
        finally:
            self.wake()

    def shutdown(self, timeout_sec: float | None = None, *, wait_for_threads: bool = True) -> bool:
        """End all spinning, remove the nodes, and wait for callbacks that run; return True."""
        result = super().shutdown(timeout_sec)
        self._executor.shutdown(wait=wait_for_threads)
        return result
