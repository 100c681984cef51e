"""Futures, and the tasks that an executor runs."""

from __future__ import annotations

import inspect
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Generator
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rclpy import _time_source

if TYPE_CHECKING:
    from rclpy.executors import Executor

T = TypeVar("T")


class _Awaiting(threading.local):
    """The future for which the coroutine waits that this thread ran last."""

    future: Future[Any] | None = None


_awaiting = _Awaiting()
_PENDING, _CANCELLED, _FINISHED = "pending", "cancelled", "finished"


class Future(Generic[T]):
    """A value that will be there later.

    Callbacks run on the executor of a future that has one, else in the thread that ends the future.
    `done()` is False for a cancelled future, as in rclpy. An exception that nobody asks for is
    printed to standard error when the future is deleted.
    """

    def __init__(self, *, executor: Executor | None = None) -> None:
        self._state = _PENDING
        self._result: Any = None
        self._exception: BaseException | None = None
        self._is_retrieved = False
        self._callbacks: list[Callable[[Any], Any]] = []
        self._hooks: list[Callable[[], Any]] = []
        self._lock = threading.Lock()
        self._set_executor(executor)

    def __del__(self) -> None:
        if self._exception is not None and not self._is_retrieved:
            said = f"The following exception was never retrieved: {self._exception}"
            print(said, file=sys.stderr)

    def __await__(self) -> Generator[Any, None, T]:
        while self._state == _PENDING:
            _awaiting.future = self  # Yields None, which asyncio takes for a pause.
            yield
            _awaiting.future = None
        value: T = self.result()
        return value

    def done(self) -> bool:
        """Return True if a result or an exception is set."""
        return self._state == _FINISHED

    def cancelled(self) -> bool:
        """Return True if the future was cancelled."""
        return self._state == _CANCELLED

    def cancel(self) -> None:
        """Cancel the future and schedule the callbacks; do nothing once it is done."""
        self._finish(_CANCELLED)

    def result(self) -> Any:
        """Return the value; raise the exception if one was set.

        While there is none, and for a cancelled future, the value is None.
        """
        self._is_retrieved = True
        if self._exception is not None:
            raise self._exception
        return self._result

    def exception(self) -> BaseException | None:
        """Return the exception, or None while none is set."""
        self._is_retrieved = True
        return self._exception

    def set_result(self, result: T) -> None:
        """Set the value and schedule the callbacks; a value set before is replaced.

        A cancelled future becomes done by this. An exception set before stays.
        """
        self._result = result
        self._finish(_FINISHED, force=True)

    def set_exception(self, exception: BaseException) -> None:
        """Set the exception and schedule the callbacks; an exception set before is replaced.

        A cancelled future becomes done by this.
        """
        self._exception, self._is_retrieved = exception, False
        self._finish(_FINISHED, force=True)

    def add_done_callback(self, callback: Callable[[Any], Any]) -> None:
        """Call `callback(self)` when the future is done or cancelled."""
        with self._lock:
            if self._state == _PENDING:
                self._callbacks.append(callback)
                return
        executor = self._executor()
        if executor is None:
            callback(self)
        else:
            executor.create_task(callback, self)

    def remove_done_callback(self, callback: Callable[[Any], Any]) -> bool:
        """Remove a callback; return False if it is not there, or the future has ended."""
        with self._lock:
            if callback not in self._callbacks:
                return False
            self._callbacks.remove(callback)
            return True

    def _set_executor(self, executor: Executor | None) -> None:
        self._executor: Callable[[], Executor | None] = (
            (lambda: None) if executor is None else weakref.ref(executor)
        )

    def _finish(self, state: str, *, force: bool = False) -> None:
        with self._lock:
            if self._state != _PENDING and not force:
                return
            self._state = state
            callbacks, self._callbacks = self._callbacks, []
            hooks, self._hooks = self._hooks, []
        for hook in hooks:
            hook()
        executor = self._executor()
        for callback in callbacks:
            if executor is not None:
                executor.create_task(callback, self)
                continue
            try:
                callback(self)
            except Exception as error:
                warnings.warn(f"Unhandled exception in done callback: {error}", stacklevel=2)

    def _when_done(self, hook: Callable[[], Any]) -> bool:
        """Call `hook()` in the thread that ends the future, before the callbacks.

        Return False, and call nothing, if the future has ended. The same hook is kept once.
        """
        with self._lock:
            if self._state == _PENDING and hook not in self._hooks:
                self._hooks.append(hook)
            return self._state == _PENDING


class Task(Future[T]):
    """A function or coroutine on an executor: a future of the value that it returns."""

    def __init__(
        self,
        handler: Any,
        args: tuple[Any, ...] = (),
        kwargs: dict[str, Any] | None = None,
        executor: Executor | None = None,
    ) -> None:
        super().__init__(executor=executor)
        kwargs = kwargs or {}
        if inspect.iscoroutinefunction(handler):
            handler = handler(*args, **kwargs)
        is_begun = inspect.iscoroutine(handler)
        self._coroutine: Any = handler if is_begun else None
        self._call: Any = None if is_begun else partial(handler, *args, **kwargs)
        self._is_executing = False
        self._itself: Task[T] | None = None
        self._release: Callable[[], None] | None = None  # Releases the callback group.

    def _finish(self, state: str, *, force: bool = False) -> None:
        if self._release is not None:
            self._release()
        super()._finish(state, force=force)

    def executing(self) -> bool:
        """Return True while the task's code runs, not before, after, or at an `await`."""
        return self._is_executing

    def __call__(self) -> None:
        """Run the task, or go on from its last `await`; do nothing once it has ended.

        What the function raises becomes the task's exception.
        """
        if self._state != _PENDING:
            return
        self._is_executing = True
        try:
            if self._coroutine is None:
                call, self._call = self._call, None
                self.set_result(call())
            else:
                self._step()
        except Exception as error:
            self.set_exception(error)
        self._is_executing = False

    def cancel(self) -> None:
        """Cancel the task, and close its coroutine; do nothing once it has ended."""
        if self._state == _PENDING and self._coroutine is not None:
            self._coroutine.close()
        super().cancel()

    def _step(self) -> None:
        while True:
            _awaiting.future = None
            try:
                self._coroutine.send(None)
            except StopIteration as stop:
                self.set_result(stop.value)
                return
            awaited = _awaiting.future
            if awaited is None:
                self._resume()
                return
            # The task keeps itself alive. If it were freed while the garbage collector closes its
            # inner coroutine, that coroutine would be closed a second time.
            self._itself = self
            if awaited._when_done(self._resume):
                return
            self._itself = None

    def _resume(self) -> None:
        """Queue the task for the executor's next turn, without waking the executor.

        A future set from another thread is noticed when the executor next wakes, as on ROS 2.
        """
        self._itself = None
        executor = self._executor()
        if executor is not None:
            executor._resume(self)


def wait_for(future: Future[Any], timeout_sec: float | None) -> bool:
    """Block until the future is done or cancelled, while another thread spins."""
    answered = threading.Condition()

    def wake(_: Future[Any]) -> None:
        with answered:
            answered.notify_all()

    future.add_done_callback(wake)
    with answered:
        until = _time_source.patience_ns(timeout_sec)
        return _time_source.wait_until(answered, lambda: future.done() or future.cancelled(), until)
