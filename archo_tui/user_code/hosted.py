"""The base of what the console runs: ARCHO's own nodes, and the user's programs."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod

from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.user_code.usage import Usage, of_threads

JOIN_TIMEOUT = 3.0  # Seconds that it has to end once it is asked to.
KILL_TIMEOUT = 0.5  # Seconds that it then takes at most.


class HostedThread(ABC):
    """A thread that runs one node or a program, until that has ended or is stopped."""

    thread_class: type[threading.Thread] = threading.Thread

    def __init__(self, state: Hosted) -> None:
        self.state = state
        self.served = state.serves  # The services and actions that it was known to serve.
        self.was_forced = False  # It was ended by force.
        self._stopping = threading.Event()
        # What it prints is known by the name of the thread.
        self._thread = self.thread_class(target=self._run, name=state.name, daemon=True)

    @property
    def name(self) -> str:
        """The first of `names`."""
        return self.names[0]

    @property
    def names(self) -> tuple[str, ...]:
        """The full names of its nodes on the graph, the oldest first; never empty.

        Without one, the name of the first node that it ever made, the planned one, or the file's.
        """
        return self.node_names() or (self.state.name,)

    @property
    def is_stopping(self) -> bool:
        """True if it has been asked to end."""
        return self._stopping.is_set()

    @property
    def is_over(self) -> bool:
        """True if its thread has ended, or was never begun."""
        return not self._thread.is_alive()

    def current_states(self) -> tuple[Hosted, ...]:
        """Return a state for each node, or one if there is none; each with all that they serve."""
        return tuple(self.state._replace(name=name, serves=self.served) for name in self.names)

    def begin(self) -> None:
        """Start the thread; call this once only."""
        self._thread.start()

    def begin_to_stop(self) -> None:
        """Ask it to end, without waiting for its end; a second call does nothing."""
        if self._stopping.is_set():
            return
        self._stopping.set()
        if self._thread.is_alive():
            self.interrupt()

    def join(self, timeout: float) -> bool:
        """Wait for the end of the thread, at most `timeout` seconds; return `is_over`."""
        if self._thread.ident is not None:
            self._thread.join(max(timeout, 0.0))
        return self.is_over

    def stop(self, timeout: float = JOIN_TIMEOUT, kill_timeout: float = KILL_TIMEOUT) -> bool:
        """Ask it to end and wait for that; end it by force if it takes too long.

        Its state becomes STOPPED, unless it has crashed. What it left on the graph is taken off.
        False, and STUCK, if it still runs.
        """
        self.begin_to_stop()
        if not self.join(timeout):
            self.was_forced = True
            self.force_end()
            if not self.join(kill_timeout):
                self.state = self.state._replace(name=self.name, life=Life.STUCK)
                return False
        self.release()
        if self.state.life is not Life.CRASHED:
            self.state = self.state._replace(life=Life.STOPPED, error="")
        return True

    def usage(self) -> Usage | None:
        """Return the processor time and memory that it has taken; None if that is not known."""
        return of_threads([self._thread])

    def node_names(self) -> tuple[str, ...]:
        """Return the full names of its nodes on the graph, the oldest first, if they may change."""
        return ()

    @abstractmethod
    def _run(self) -> None:
        """Run it, in its thread."""

    @abstractmethod
    def interrupt(self) -> None:
        """Interrupt it; may be called again, and on any thread."""

    def force_end(self) -> None:  # noqa: B027
        """End it by force if it runs and can be, without waiting; may be called on any thread."""

    def release(self) -> None:  # noqa: B027
        """Take the nodes that it has left off the graph."""
