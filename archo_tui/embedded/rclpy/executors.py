"""Executors, which run the callbacks of their nodes while somebody spins them.

What is ready stands in one queue and gets one turn: an entity that has more work goes behind all
others. So a task, and a service's answer, never wait behind a queue full of messages. Timers that
are due come first, as in rclpy, but not twice before something else had its turn.
Waiting costs nothing: a heap of timers, one condition variable.
"""

from __future__ import annotations

import heapq
import inspect
import itertools
import os
import threading
import warnings
from collections import OrderedDict, deque
from collections.abc import Callable
from concurrent.futures import Future as PoolFuture
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from types import CoroutineType
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy import _time_source
from rclpy._entity import Entity, TimedEntity
from rclpy.context import Context
from rclpy.task import Future, Task
from rclpy.utilities import get_default_context

if TYPE_CHECKING:
    from rclpy.node import Node


Work = Callable[[], Any]  # A task, or what an entity wants called.
ExecutorT = TypeVar("ExecutorT", bound="Executor")
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


class Executor:
    """The base of executors, which collects work and hands it out piece by piece.

    A user's own executor defines `spin_once`, using `wait_for_ready_callbacks`. The constructor
    raises RuntimeError for a context that has not begun, or has ended. Leaving a `with` shuts the
    executor down.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = get_default_context() if context is None else context
        if not self._context.ok():
            raise RuntimeError("Context must be initialized before an executor can be created")
        self._nodes: dict[Node, None] = {}  # In the order of adding.
        self._lock = threading.RLock()  # Taken more cheaply than by the condition.
        self._condition = threading.Condition(self._lock)
        self._ready: OrderedDict[Entity | Task[Any], None] = OrderedDict()
        self._due: deque[Entity] = deque()  # Timers, which come before what is ready.
        self._timers_wait = False  # True until something else than a timer had its turn.
        self._blocked: list[Entity] = []  # Ready, but their callback group is taken.
        self._timers: list[tuple[int, int, TimedEntity]] = []
        self._order = itertools.count()
        self._is_shutdown = False
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
        with self._condition:
            if node in self._nodes:
                return False
            self._nodes[node] = None
            node.executor = self
            for entity in node._entities():
                if isinstance(entity, TimedEntity):
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
            for item in [i for i in self._ready if isinstance(i, Entity) and i._node is node]:
                del self._ready[item]
            self._due = deque(e for e in self._due if e._node is not node)
            self._blocked = [e for e in self._blocked if e._node is not node]

    def get_nodes(self) -> list[Node]:
        """Return the nodes in the order in which they were added."""
        return list(self._nodes)

    def create_task(self, callback: Callable[..., Any], *args: Any, **kwargs: Any) -> Task[Any]:
        """Schedule a function or coroutine on this executor, from any thread, and return its task.

        The task runs when the executor is spun.
        """
        task: Task[Any] = Task(callback, args, kwargs, executor=self)
        self._resume(task)
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
        future._when_done(self.wake)
        while self._context.ok() and not future.done() and not future.cancelled():
            left_ns = None if deadline is None else deadline - _time_source.monotonic_ns()
            if self._is_shutdown:
                return
            left = None if left_ns is None else max(left_ns, 0) / 1e9
            self._spin_once_until_future_complete(future, left)
            if left_ns is not None and left_ns <= 0:
                return

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run one callback or task; return without one once the future is done or the time is up.

        Unlike in rclpy, work that is ready is run even if the future is done already. What the
        callback raises is raised here.
        """
        raise NotImplementedError

    def _spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
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
        with self._lock:  # Another thread may find the group taken just now.
            if self._blocked:
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
        """Queue a new task, or one whose awaited future is done."""
        with self._condition:
            self._ready[task] = None
            self._notify()

    def _add_timer(self, timer: TimedEntity) -> None:
        with self._condition:
            if timer._node in self._nodes:  # Otherwise it is added with its node.
                heapq.heappush(self._timers, (timer._next_ns, next(self._order), timer))
                self._notify()

    def _next_work(
        self, timeout_sec: float | None, stop: Callable[[], bool]
    ) -> tuple[Work, Entity | None]:
        """Block until there is a piece of work, and take it.

        TimeoutException is raised when the time is up, or `stop()` returned True.
        """
        deadline: int | None = -1  # Unknown until it is needed.
        with self._lock:
            while True:
                if self._is_shutdown:
                    raise ShutdownException
                if not self._context._ok:
                    raise ExternalShutdownException
                found = self._pop()
                if found is not None:
                    return found
                if deadline == -1:
                    deadline = _time_source.deadline_ns(timeout_sec)
                if stop() or (deadline is not None and _time_source.monotonic_ns() >= deadline):
                    raise TimeoutException
                until = self._timers[0][0] if self._timers else deadline
                if deadline is not None and until is not None:
                    until = min(until, deadline)
                self._notified = False
                _time_source.wait(self._condition, lambda: self._is_idle() and not stop(), until)

    def _is_idle(self) -> bool:
        """Return True until work is announced, so that a wait goes on."""
        return not self._notified

    def _collect_timers(self) -> None:
        while self._timers and self._timers[0][0] <= _time_source.monotonic_ns():
            timer = heapq.heappop(self._timers)[2]
            # The timer may count simulated time by now.
            if timer._node.executor is self and timer._is_due():
                self._due.append(timer)

    def _pop(self) -> tuple[Work, Entity | None] | None:
        """Take the next piece of work, or return None."""
        while True:
            if self._timers and not self._due and not (self._timers_wait and self._ready):
                self._collect_timers()
                self._timers_wait = bool(self._due)
            if self._due:
                item: Entity | Task[Any] = self._due.popleft()
            elif self._ready:
                item = self._ready.popitem(last=False)[0]
                self._timers_wait = False
            else:
                return None
            if isinstance(item, Task):
                return item, None
            work = self._take(item)
            if work is not None:
                return work, item

    def _take(self, entity: Entity) -> Work | None:
        """Claim an entity's callback group and take a piece of its work.

        None is returned without work, and while the group is taken: then the entity is tried again
        as soon as a callback has ended.
        """
        if not entity.callback_group.beginning_execution(entity):
            self._blocked.append(entity)
            return None
        work = entity._take()
        if entity._waiting():
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

    def _spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        self._spin_once(timeout_sec, future.done)

    def _spin_once(self, timeout_sec: float | None, stop: Callable[[], bool]) -> None:
        try:
            work, entity = self._next_work(timeout_sec, stop)
        except (TimeoutException, ShutdownException):
            return
        self._run(work, entity)

    _run = Executor._execute


class MultiThreadedExecutor(SingleThreadedExecutor):
    """An executor with a pool of threads; callback groups say what may run at the same time.

    `spin_once` starts a callback and does not wait for its end: what the callback raises, a later
    `spin_once` raises.
    """

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        if num_threads is None:
            cores = getattr(os, "sched_getaffinity", lambda _: range(os.cpu_count() or 2))
            num_threads = len(cores(0))
        if num_threads == 1:
            warnings.warn(
                "MultiThreadedExecutor is used with a single thread.\n"
                "Use the SingleThreadedExecutor instead.",
                stacklevel=2,
            )
        self._executor = ThreadPoolExecutor(num_threads)
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
