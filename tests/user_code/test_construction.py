"""A node whose constructor takes its time: others are started meanwhile, and it when it is made."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.snapshot import Life
from archo_tui.session.session import Session
from tests.support import chosen
from tests.support.waiting import DEADLINE, wait_until
from tests.user_code.support import is_told, life, running, states, texts, written

pytestmark = pytest.mark.real_time

ASKER = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger


class Asker(Node):
    def __init__(self):
        super().__init__("asker")
        client = self.create_client(Trigger, "blink")
        while not client.wait_for_service(timeout_sec=1.0):
            pass
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self, future)
        print("answer:", future.result().message)
"""
LAMP = """
from rclpy.node import Node
from std_srvs.srv import Trigger


class Lamp(Node):
    def __init__(self):
        super().__init__("lamp")
        self.create_service(Trigger, "blink", self.blink)

    def blink(self, request, response):
        response.message = "on"
        return response
"""
# serves a STOP, and is made when there is a file called `go`
MOTOR = """
import time
from pathlib import Path
from rclpy.node import Node
from std_srvs.srv import Trigger


class Motor(Node):
    def __init__(self):
        super().__init__("motor")
        self.said = []
        self.declare_parameter("speed", 1.0)
        self.create_service(Trigger, "halt", self.halt)
        self.create_timer(0.01, lambda: self.said.append("drives"))
        while not Path("go").exists():
            time.sleep(0.01)  # here

    def halt(self, request, response):
        self.said.append("halted")
        response.success = True
        return response
"""


@contextmanager
def hosting(*files: Path, **options: Any) -> Iterator[Session]:
    """A session at whose end nothing is left."""
    with running(*files, **options) as session:
        yield session
        assert session.host.stop() == []


@pytest.fixture(autouse=True)
def _impatient(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if chosen.ENGINE == "embedded":
        monkeypatch.setattr("archo_tui.user_code.program.START_TIME", 0.3)


def test_a_constructor_is_answered_by_a_later_files_node_and_holds_up_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.user_code.program.START_TIME", DEADLINE)
    began = time.monotonic()
    with hosting(written("asker.py", ASKER), written("lamp.py", LAMP)) as session:
        assert chosen.ENGINE != "embedded" or time.monotonic() - began < 15.0
        wait_until(lambda: life(session, "/asker") is Life.UP)
        wait_until(lambda: "answer: on" in texts(session))
        if chosen.ENGINE == "embedded":
            late = "asker.py:11: Asker.__init__ waits for other nodes, in: while not client."
            wait_until(lambda: is_told(session, late))


INSIDE = pytest.mark.skipif(chosen.ENGINE != "embedded", reason="a child cannot be looked into")


@INSIDE
def test_what_it_waits_for_is_said_with_the_line_until_it_is_stopped() -> None:
    with hosting(written("asker.py", ASKER)) as session:
        line = "line 11, in: while not client.wait_for_service("
        wait_until(lambda: states(session)["/asker"].error.startswith(line))
        assert life(session, "/asker") is Life.STARTING
        assert session.host.start_node("/asker") == (Code.REFUSED, "/asker is starting")
        assert session.host.stop_node("/asker") == (Code.DONE, "/asker stopped")
        assert life(session, "/asker") is Life.STOPPED
        wait_until(lambda: "/asker" not in [n.name for n in session.robot.snapshot.nodes])
        assert session.host.start_node("/asker").ok
        wait_until(lambda: life(session, "/asker") is Life.STARTING)


def test_one_that_fails_late_has_crashed_and_names_its_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if chosen.ENGINE == "embedded":
        monkeypatch.setattr("archo_tui.user_code.program.START_TIME", 4.0)  # It begins within that.
    fails = MOTOR.replace("\n    def halt", "        1 / 0\n\n    def halt")
    with hosting(written("motor.py", fails)) as session:
        wait_until(lambda: "/motor" in session.host.names())
        if chosen.ENGINE == "embedded":  # a child cannot be looked into
            late = re.compile(r"motor\.py:1[56]: Motor\.__init__ has not returned, in: ")
            wait_until(lambda: any(late.match(text) for text in texts(session)))
        Path("go").touch()
        wait_until(lambda: life(session, "/motor") is Life.CRASHED)
        assert states(session)["/motor"].error == (
            "line 17: ZeroDivisionError: division by zero, in: 1 / 0"
        )
        wait_until(lambda: any("crashed: line 17: " in text for text in texts(session)))


def test_a_session_that_does_not_begin_leaves_no_thread_of_a_program() -> None:
    lamp, broken = written("lamp.py", LAMP), written("broken.py", "def")
    with pytest.raises(ArchoError, match=r"broken\.py:1: SyntaxError"), hosting(lamp, broken):
        pass
    wait_until(lambda: not any("/lamp" in thread.name for thread in threading.enumerate()))
