"""The module `rclpy.context`: what `init` begins and `shutdown` ends."""

from __future__ import annotations

import inspect
import os
import threading
import weakref
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from rclpy import _arguments, _process, logging
from rclpy._graph import Graph, graph_of

if TYPE_CHECKING:
    from rclpy.node import Node


class Context:
    """A context: arguments, a domain, and the nodes made in it.

    Leaving a `with` shuts the context down.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._ok = self._has_begun = False
        self._domain_id = 0
        self._arguments = _arguments.Arguments()
        self._callbacks: list[Callable[[], Callable[[], None] | None]] = []
        self._nodes: weakref.WeakSet[Node] = weakref.WeakSet()

    def init(self, args: Sequence[str] | None = None, *, domain_id: int | None = None) -> None:
        """Begin the context, which succeeds only once. Nodes of one domain see each other."""
        process = _process.current()
        args = process.begin_context(args)
        with self._lock:
            if self._has_begun:
                raise RuntimeError("Context.init() must only be called once")
            self._arguments = _arguments.parse(args)
            if domain_id is None:
                domain_id = process.domain_id
            if domain_id is None:
                domain_id = int(os.environ.get("ROS_DOMAIN_ID") or 0)
            if domain_id < 0:
                raise RuntimeError(f"Domain id ({domain_id}) should not be lower than zero.")
            self._domain_id = domain_id
            self._ok = self._has_begun = True
        logging.configure(self._arguments.stdout_logs, self._arguments.log_level)

    def ok(self) -> bool:
        """Return True between `init` and `shutdown`, else False."""
        return self._ok

    def get_domain_id(self) -> int:
        """Return the domain whose nodes this context's nodes see."""
        if not self._ok:
            raise RuntimeError("Context must be initialized before it can have a domain id")
        return self._domain_id

    def on_shutdown(self, callback: Callable[[], None]) -> None:
        """Call a function once when the context is shut down, or at once if it has been.

        A bound method is not called if its object is gone by then.
        """
        if self._has_begun and not self._ok:
            callback()
            return
        reference = weakref.WeakMethod(callback) if inspect.ismethod(callback) else lambda: callback
        # A method is kept once: a clock asks for it at each sleep.
        others = [known for known in self._callbacks if known != reference]
        self._callbacks = [known for known in others if known() is not None] + [reference]

    def shutdown(self) -> None:
        """End the context: its nodes leave the graph, then callbacks of `on_shutdown` are called.

        Executors of the context stop spinning.
        """
        with self._lock:
            if not self._ok:
                if self._has_begun:
                    raise RuntimeError("Context already shutdown.")
                raise RuntimeError("Context must be initialized before it can be shutdown")
            self._ok = False
        for node in list(self._nodes):
            node._leave_graph()
        callbacks, self._callbacks = self._callbacks, []
        for reference in callbacks:
            callback = reference()
            if callback is not None:
                callback()

    def try_shutdown(self) -> None:
        """Shut the context down, unless it has not begun or has ended."""
        if self._ok:
            self.shutdown()

    def __enter__(self) -> Context:
        return self

    def __exit__(self, *_: object) -> None:
        self.try_shutdown()

    @property
    def _graph(self) -> Graph:
        return graph_of(self._domain_id)
