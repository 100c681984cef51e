"""A verb without a console: attaches to the ROS 2 graph, acts, and leaves."""

from __future__ import annotations

import asyncio
import os
import queue
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Protocol

from archo_tui.remote.client import UNANSWERED, Unreached
from archo_tui.remote.desk import Desk
from archo_tui.remote.protocol import is_stop
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import Snapshot
from archo_tui.station.queue import QueuedGoal
from archo_tui.station.station import Station
from archo_tui.verbs.base import PATIENCE


class HasStation(Protocol):
    """A session."""

    station: Station


@contextmanager
def attached(begin: Callable[[], AbstractContextManager[HasStation]]) -> Iterator[Attached]:
    """A robot on the graph, while the session runs. Raises Unreached when none is there."""
    with begin() as session:
        found = Attached(session.station)
        try:
            yield found
        finally:
            found.close()


_TICK = 1.0  # s
_LOOK = 0.05  # s between two looks for the robot
_END = 5.0  # s for the loop to end


class Attached:
    """As a connection to a console, of a station in this process."""

    def __init__(self, station: Station) -> None:
        """The session that it belongs to runs. Raises Unreached when no robot is on the graph."""
        self.pid = os.getpid()
        self._station, self._desk = station, Desk(station)
        self._said: queue.Queue[dict[str, Any]] = queue.Queue()
        self._number = 0
        self._loop = asyncio.new_event_loop()
        self._tasks: set[asyncio.Task[None]] = set()
        self._thread = threading.Thread(target=self._run, name="once", daemon=True)
        found = threading.Event()
        self._begin(self._live(found))
        self._thread.start()
        if not found.wait(PATIENCE):
            self.close()
            raise Unreached(f"no console runs here, and no robot is {station.unseen}")

    def request(self, within: float | None = None, **asked: Any) -> Iterator[dict[str, Any]]:
        """Yields all that is said to it, the result last; `within` as in `rest`."""
        self._number += 1
        stops = self._station.robot.stops
        if stops.is_stop_call(asked["words"]):
            asked["words"] = ["stop"]
        request = {"id": self._number, **asked}
        self._desk.serve(self, request, stops.register() if is_stop(asked) else stops.count)
        yield from self.rest(within)

    def rest(self, within: float | None = None) -> Iterator[dict[str, Any]]:
        """What is said until the result. Raises Unreached when nothing is said for so many s."""
        said: dict[str, Any] = {}
        while "code" not in said:
            try:
                said = self._said.get(timeout=within)
            except queue.Empty:
                raise Unreached(UNANSWERED) from None
            yield said

    def send(self, said: dict[str, Any]) -> None:
        """Say something more to what is being carried out."""
        self._desk.answer(self, said, self._station.robot.stops.count)

    def close(self) -> None:
        """Leave."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_END)

    # as a client of the desk, on the loop

    def tell(self, said: dict[str, Any]) -> None:
        """Something is said to us."""
        self._said.put(said)

    def done(self) -> None:
        """What was asked for has ended."""

    # as the station's face

    def carry_out(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Begin it."""
        self._begin(work())

    def beside(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Begin it."""
        self._begin(work())

    def goal_answered(self, wanted: QueuedGoal, outcome: Outcome) -> None:
        """Whoever waits for it is told."""

    @property
    def has_person(self) -> bool:
        """Who allows something sits at a console."""
        return False

    def ask_no_more(self) -> None:
        """Whoever is asked here said STOP."""

    def restart(self, why: str) -> None:
        """Nothing of the user's own runs here."""

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()
        for task in self._tasks:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*self._tasks, return_exceptions=True))
        self._loop.close()

    def _take(self, snapshot: Snapshot) -> None:
        self._station.take(snapshot)

    async def _live(self, found: threading.Event) -> None:
        station = self._station
        station.run_on(self)
        station.robot.subscribe(self._take)
        while not station.robot.snapshot.nodes:
            await asyncio.sleep(_LOOK)
        found.set()
        while True:
            await asyncio.sleep(_TICK)
            station.tick()
