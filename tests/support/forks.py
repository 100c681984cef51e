"""Runs the tests in forks of the process that has collected them, as many as xdist is told.

Each worker of pytest-xdist imports and collects all tests anew, which is 5 s of computing for
each of six. A fork has all that. Elsewhere than on Linux, where a fork is not safe, the workers
of xdist run the tests.

Tests that compute run in no more forks than there are processors: beyond that, each of them only
takes longer, and a quarter more computing. The other forks run those that mostly wait, for the
machine's clock or for other processes.
"""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections import deque
from collections.abc import Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from types import SimpleNamespace
from typing import Any, NoReturn
from unittest.mock import patch

import pytest
from _pytest.runner import runtestprotocol

from tests.support import chosen

_MOST = 10  # Tests that a fork gets at a time; fewer towards the end.
_END_TIMEOUT = 60  # Seconds for the threads that tests left to end, each of which is a defect.


class _Fork:
    """The parent's side of a forked process."""

    def __init__(self, number: int, pid: int, connection: Connection) -> None:
        self.number, self.pid, self.connection = number, pid, connection
        self.given: deque[int] = deque()  # Indices of the tests that it has not reported.
        self.computes = False  # True while its tests are such that compute.


class Forks:
    """A plugin that distributes the collected tests among forked processes.

    Args:
        count: How many processes run at a time.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._processors = len(os.sched_getaffinity(0))
        self._computing: deque[int] = deque()  # Indices of tests that nobody has been given.
        self._waiting: deque[int] = deque()
        self._forks: list[_Fork] = []
        self._defects: list[str] = []  # Of forks that did not end as they should.

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool | None:
        collected = not session.testsfailed or session.config.option.continue_on_collection_errors
        if session.config.option.collectonly or not collected:
            return None
        for index, item in enumerate(session.items):
            (self._waiting if _mostly_waits(item) else self._computing).append(index)
        useful = min(self._processors, len(self._computing)) + len(self._waiting)
        try:
            for number in range(min(self._count, useful)):
                self._forks.append(self._start(session, number))
            while self._forks:
                for connection in wait([fork.connection for fork in self._forks]):
                    fork = next(one for one in self._forks if one.connection is connection)
                    self._receive(session, fork)
                if session.shouldfail:
                    raise session.Failed(session.shouldfail)
                if session.shouldstop:
                    raise session.Interrupted(session.shouldstop)
            if self._defects:
                raise session.Failed("; ".join(self._defects))
            assert not self._computing
            assert not self._waiting
        finally:
            for fork in self._forks:
                os.kill(fork.pid, signal.SIGKILL)
                os.waitpid(fork.pid, 0)
        return True

    def _start(self, session: pytest.Session, number: int) -> _Fork:
        ours, its = Pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        pid = os.fork()
        if pid == 0:
            ours.close()
            for other in self._forks:
                other.connection.close()
            _Child(session, number, its).run_and_exit()
        its.close()
        return _Fork(number, pid, ours)

    def _receive(self, session: pytest.Session, fork: _Fork) -> None:
        """Take what a fork sends: None asks for more tests, else it is what came of one."""
        try:
            message = fork.connection.recv()
        except (EOFError, ConnectionError):
            self._take_leave(session, fork)
            return
        if message is None:
            portion = self._next_portion(fork)
            fork.given += portion
            with contextlib.suppress(ConnectionError):
                fork.connection.send(portion)
            return
        item = session.items[fork.given.popleft()]
        hook = session.config.hook
        for data in message:
            report = hook.pytest_report_from_serializable(config=session.config, data=data)
            self._log(session, fork, report)
        hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)

    def _log(self, session: pytest.Session, fork: _Fork, report: pytest.TestReport) -> None:
        name = f"fork {fork.number}"
        # What pytest reads of a worker of xdist: it writes the name in front of what it reports.
        vars(report)["node"] = SimpleNamespace(
            gateway=SimpleNamespace(id=name), _workerinfocache=name
        )
        session.config.hook.pytest_runtest_logreport(report=report)

    def _next_portion(self, fork: _Fork) -> list[int]:
        """Return the indices of the tests that a fork runs next; none: it is to end."""
        others = sum(one.computes for one in self._forks if one is not fork)
        most = self._processors + (not self._waiting)
        fork.computes = others < most and len(self._computing) > 0
        left = self._computing if fork.computes else self._waiting
        size = min(_MOST, 1 + len(left) // (4 * self._count))
        return [left.popleft() for _ in range(min(size, len(left)))]

    def _take_leave(self, session: pytest.Session, fork: _Fork) -> None:
        """Note that a fork has ended; when it crashed, its test failed, and another one goes on."""
        self._forks.remove(fork)
        fork.connection.close()
        status = os.waitstatus_to_exitcode(os.waitpid(fork.pid, 0)[1])
        if not fork.given:
            if status != 0:
                self._defects.append(f"fork {fork.number} ended with {status} while it ran no test")
            return
        item = session.items[fork.given.popleft()]
        self._log(session, fork, _crash(item, f"the process of this test ended with {status}"))
        left = self._computing if fork.computes else self._waiting
        left.extendleft(reversed(fork.given))
        self._forks.append(self._start(session, fork.number))


def _mostly_waits(item: pytest.Item) -> bool:
    """Return True for a test that lives by the machine's clock or starts other processes.

    On real ROS 2, where time cannot be moved, every test does.
    """
    is_real = chosen.ENGINE != "embedded"
    return is_real or any(map(item.get_closest_marker, ("real_time", "posix")))


def _crash(item: pytest.Item, said: str) -> pytest.TestReport:
    return pytest.TestReport(item.nodeid, item.location, {}, "failed", said, "call")


class _Child:
    """The forked process's side: runs what the parent gives."""

    def __init__(self, session: pytest.Session, number: int, parent: Connection) -> None:
        self._session, self._number, self._parent = session, number, parent
        self._reports: list[object] = []

    def run_and_exit(self) -> NoReturn:
        try:
            self._take_own_things()
            portion = self._ask()
            while portion:
                for place, index in enumerate(portion):
                    following = portion[place + 1 :] or self._ask()
                    self._run(index, following[0] if following else None)
                portion = following
            capture: Any = self._session.config.pluginmanager.getplugin("capturemanager")
            capture.suspend_global_capture()
            faulthandler.dump_traceback_later(_END_TIMEOUT, exit=True)
            threading._shutdown()  # type: ignore[attr-defined]  # As an interpreter ends.
        except (ConnectionError, EOFError, KeyboardInterrupt):
            os._exit(1)  # The parent has gone, or was interrupted as well.
        except BaseException:
            traceback.print_exc(file=sys.__stderr__)
            os._exit(1)
        os._exit(0)

    def _take_own_things(self) -> None:
        """Replace what processes cannot share: files of captured output, domains, a folder."""
        config = self._session.config
        if config.getoption("capture") == "fd":
            capture: Any = config.pluginmanager.getplugin("capturemanager")
            captured = capture._global_capturing
            for file in (captured.out.tmpfile, captured.err.tmpfile):
                with tempfile.TemporaryFile() as own:
                    os.dup2(own.fileno(), file.fileno())
        chosen.use_domains_of(self._number)
        folders: Any = vars(config)["_tmp_path_factory"]
        folders._basetemp = folders.mktemp(f"fork{self._number}-")
        config.pluginmanager.register(self)

    def _ask(self) -> list[int]:
        self._parent.send(None)
        portion: list[int] = self._parent.recv()
        return portion

    def _run(self, index: int, following: int | None) -> None:
        """Run a test as pytest does, within what plugins put around it, and send its reports."""
        items = self._session.items
        next_item = None if following is None else items[following]
        self._reports = []
        items[index].ihook.pytest_runtest_protocol(item=items[index], nextitem=next_item)
        self._parent.send(self._reports)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool:
        serialize = item.config.hook.pytest_report_to_serializable
        for report in runtestprotocol(item, log=False, nextitem=nextitem):
            self._reports.append(serialize(config=item.config, report=report))
        return True

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_teardown(self, nextitem: pytest.Item | None) -> Iterator[None]:
        """Let the last test of this process fail for what no test of it has closed."""
        yield
        if nextitem is None:
            unclosed: list[Any] = []
            with patch("sys.unraisablehook", unclosed.append):
                gc.collect()
            if unclosed:
                raise unclosed[0].exc_value
