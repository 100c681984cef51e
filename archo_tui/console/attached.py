"""A verb without a console: attaches to the ROS 2 graph, acts, and leaves."""

from __future__ import annotations

import asyncio
import os
import queue
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Protocol

from archo_tui.client.connection import UNANSWERED, Unreached
from archo_tui.client.protocol import is_stop
from archo_tui.console.session import RequestHandler
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.shutdown import nothing_published_while_suspended
from archo_tui.station.station import Station
from archo_tui.text.state import elsewhere_text
from archo_tui.verbs.verb import ROBOT_TIMEOUT


class HasStation(Protocol):
    """The interface of a session, as far as a verb without a console needs it."""

    station: Station


@contextmanager
def attached(
    make_session: Callable[[], AbstractContextManager[HasStation]],
) -> Iterator[InProcessConnection]:
    """Run a session for one verb, and yield a connection to its station, or raise Unreached."""
    with make_session() as session:
        connection = InProcessConnection(session.station)
        try:
            with nothing_published_while_suspended(session.station.robot):
                yield connection
        finally:
            connection.close()


_TICK = 1.0  # Seconds between two ticks of the station.
_FIND_PERIOD = 0.05  # Seconds between two polls of the graph for the robot.
_END_TIMEOUT = 5.0  # Seconds that the loop may take to end.


class InProcessConnection:
    """A connection to a station in this process, used like a `Connection` to a console.

    It is the client of a request handler and the station's front end at once. `request`,
    `replies`, `send` and `close` are called outside the loop's thread, all further
    methods on it.
    """

    def __init__(self, station: Station) -> None:
        """Start the loop in its thread, and wait up to 5 s for a node, or raise Unreached."""
        self.pid = os.getpid()
        self._station, self._handler = station, RequestHandler(station)
        self._replies: queue.Queue[dict[str, Any]] = queue.Queue()
        self._number = 0
        self._loop = asyncio.new_event_loop()
        self._tasks: set[asyncio.Task[None]] = set()
        self._thread = threading.Thread(target=self._run_loop, name="once", daemon=True)
        found = threading.Event()
        self._start_task(self._run_station(found))
        self._thread.start()
        if not found.wait(ROBOT_TIMEOUT):
            self.close()
            others = elsewhere_text(station.robot.snapshot)
            seen = f"in namespace {station.robot.snapshot.namespace}: {others}" if others else ""
            raise Unreached(f"no console runs here, and no robot is {seen or station.unseen}")

    def request(
        self, reply_timeout: float | None = None, **fields: Any
    ) -> Iterator[dict[str, Any]]:
        """Send a request, and yield all replies to it, the result last.

        Nothing is sent before the iterator is first advanced. A STOP is counted; a `call` of the
        STOP's service becomes one.
        """
        self._number += 1
        stops = self._station.robot.stops
        if stops.is_stop_call(fields["words"]):
            fields["words"] = ["stop"]
        request = {"id": self._number, **fields}
        self._handler.serve(self, request, stops.register() if is_stop(fields) else stops.count)
        yield from self.replies(reply_timeout)

    def replies(self, reply_timeout: float | None = None) -> Iterator[dict[str, Any]]:
        """Yield the replies that are still to come; Unreached if one takes too long."""
        reply: dict[str, Any] = {}
        while "code" not in reply:
            try:
                reply = self._replies.get(timeout=reply_timeout)
            except queue.Empty:
                raise Unreached(UNANSWERED) from None
            yield reply

    def send(self, request: dict[str, Any]) -> None:
        self._handler.on_answer(self, request)

    def close(self) -> None:
        """End the loop, and cancel what is still being carried out; wait up to 5 s for that."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_END_TIMEOUT)

    # The client of the request handler, on the loop.

    requester = ask = None
    is_process_apart = False

    def reply(self, reply: dict[str, Any]) -> None:
        self._replies.put(reply)

    def on_request_ended(self) -> None:
        """Do nothing: the result tells that the request has ended."""

    @property
    def is_behind(self) -> bool:
        return not self._replies.empty()

    # The station's front end.

    def carry_out(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        self._start_task(work())

    def run_in_background(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        self._start_task(work())

    def on_goal_answered(self, goal: QueuedGoal, outcome: Outcome) -> None:
        """Do nothing: the requester gets the answer as a result."""

    @property
    def has_person(self) -> bool:
        """Always False: a person who could allow a request of an assistant sits at a console."""
        return False

    def close_questions(self) -> None:
        """Do nothing: only the sender of the STOP could have been asked."""

    def restart(self, why: str) -> None:
        """Do nothing: this process hosts no nodes, which alone need a restart."""

    def _start_task(self, work: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _run_loop(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()
        for task in self._tasks:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*self._tasks, return_exceptions=True))
        self._loop.close()

    def _on_snapshot(self, snapshot: Snapshot) -> None:
        self._station.on_snapshot(snapshot)

    async def _run_station(self, found: threading.Event) -> None:
        station = self._station
        station.attach(self)
        station.robot.subscribe(self._on_snapshot)
        while not station.robot.snapshot.nodes:
            await asyncio.sleep(_FIND_PERIOD)
        found.set()
        while True:
            await asyncio.sleep(_TICK)
            station.tick()
