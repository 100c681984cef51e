"""A verb without a console: attaches to the ROS 2 graph, acts, and leaves."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Protocol

from archo_tui.client.connection import Connection
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import PROTOCOL
from archo_tui.console.session import RequestHandler
from archo_tui.console.socket import Server
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.shutdown import nothing_published_while_suspended
from archo_tui.station.station import Station
from archo_tui.text.state import elsewhere_text
from archo_tui.verbs.verb import ROBOT_TIMEOUT


class HasStation(Protocol):
    """The interface of a session, as far as a verb without a console needs it."""

    station: Station


@contextmanager
def attached(
    make_session: Callable[[], AbstractContextManager[HasStation]],
) -> Iterator[Connection]:
    """Run a session for one verb, and yield a connection to it that nobody else can make.

    Waits up to 5 s for a node. Raises Unreached.
    """
    with make_session() as session, contextlib.ExitStack() as ends:
        station = session.station
        frontend = ends.enter_context(contextlib.closing(_Frontend(station)))
        frontend.wait_for_robot()
        server = Server(
            lambda: RequestHandler(station), {"protocol": PROTOCOL}, station.robot.stops, print
        )
        ends.callback(server.close)
        ours, servers = socket.socketpair()
        server.greet(servers)
        connection = ends.enter_context(contextlib.closing(Connection("", ours)))
        ends.enter_context(nothing_published_while_suspended(station.robot))
        yield connection


_TICK = 1.0  # Seconds between two ticks of the station.
_FIND_PERIOD = 0.05  # Seconds between two polls of the graph for the robot.
_END_TIMEOUT = 5.0  # Seconds that the loop may take to end.


class _Frontend:
    """A station's front end without a person, whose loop runs in a thread of its own."""

    has_person = False  # A person who could allow a request of an assistant sits at a console.

    def __init__(self, station: Station) -> None:
        self._station = station
        self._tasks: set[asyncio.Task[None]] = set()
        self._has_found = threading.Event()
        self._thread = threading.Thread(target=self._run_loop, name="once", daemon=True)
        self._thread.start()

    def wait_for_robot(self) -> None:
        station = self._station
        if not self._has_found.wait(ROBOT_TIMEOUT):
            others = elsewhere_text(station.robot.snapshot)
            seen = f"in namespace {station.robot.snapshot.namespace}: {others}" if others else ""
            raise Unreached(f"no console runs here, and no robot is {seen or station.unseen}")

    def close(self) -> None:
        """End the loop, and cancel what is still being carried out; wait up to 5 s for that."""
        self._loop.call_soon_threadsafe(self._is_over.set)
        self._thread.join(_END_TIMEOUT)

    # Called on the loop.

    def run_in_background(self, work: Callable[[], Coroutine[Any, Any, None]]) -> None:
        task = self._loop.create_task(work())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    carry_out = run_in_background

    def on_goal_answered(self, goal: QueuedGoal, outcome: Outcome) -> None:
        """Do nothing: the requester gets the answer as a result."""

    def close_questions(self) -> None:
        """Do nothing: only the sender of the STOP could have been asked."""

    def restart(self, why: str) -> None:
        """Do nothing: this process hosts no nodes, which alone need a restart."""

    def _run_loop(self) -> None:
        asyncio.run(self._run_station())

    async def _run_station(self) -> None:
        station, self._loop = self._station, asyncio.get_running_loop()
        self._is_over = asyncio.Event()
        station.attach(self)
        station.robot.subscribe(self._on_snapshot)
        self.run_in_background(self._tick)
        await self._is_over.wait()

    def _on_snapshot(self, snapshot: Snapshot) -> None:
        self._station.on_snapshot(snapshot)

    async def _tick(self) -> None:
        while not self._station.robot.snapshot.nodes:
            await asyncio.sleep(_FIND_PERIOD)
        self._has_found.set()
        while True:
            await asyncio.sleep(_TICK)
            self._station.tick()
