"""A hosted node that fails fails alone, and it is said."""

from __future__ import annotations

import threading
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.snapshot import Life
from archo_tui.user_code import interrupt
from tests.support import chosen
from tests.support.waiting import wait_until
from tests.user_code.support import running, texts, written


class Bad(Node):
    """Raises in its first callback."""

    def __init__(self, **options: Any) -> None:
        super().__init__("bad", **options)
        self.create_timer(0.01, self.explode)

    def explode(self) -> None:
        raise ZeroDivisionError("boom")


class Good(Node):
    """Ticks on."""

    def __init__(self, **options: Any) -> None:
        super().__init__("good", **options)
        self.count = 0
        self.create_timer(0.01, self.tick)

    def tick(self) -> None:
        self.count += 1


def test_a_crash_is_an_event_and_the_others_go_on() -> None:
    with running(node_makers=(Bad, Good), only=False) as session:
        wait_until(lambda: "crashed: ZeroDivisionError: boom" in texts(session))
        (event,) = (event for event in session.robot.snapshot.events if event.source == "bad")
        assert event.level == "ERROR"
        bad, good = session.host.nodes
        assert bad.state.life is Life.CRASHED
        assert "in explode" in bad.state.traceback
        seen = good.node.count  # type: ignore[attr-defined]
        wait_until(lambda: good.node.count > seen)  # type: ignore[attr-defined]
        wait_until(lambda: [n.name for n in session.robot.snapshot.nodes] == ["/good"])


def test_none_of_archos_own_is_made_beside_a_programs_node_of_its_name() -> None:
    """A slow program may make it between the look for such nodes and the making of ARCHO's own."""
    with running(node_makers=(Good,), only=False) as session:
        program: Any = SimpleNamespace(is_stopping=False)
        assert session.host._make_way(program, "/late") == ""
        session.host.add(partial(Node, "late"))
        assert session.host.names() == ["/good"]
        wait_until(lambda: [n.name for n in session.robot.snapshot.nodes] == ["/good"])


def test_a_restarted_copy_keeps_its_own_name() -> None:
    with running(node_makers=(Good,), only=False) as session:
        assert session.host.copy_node("/good").ok
        assert session.host.stop_node("/good_2").ok
        assert session.host.start_node("/good_2") == (Code.DONE, "/good_2 started")
        assert [hosted.name for hosted in session.host.nodes] == ["/good", "/good_2"]
        wait_until(lambda: [n.name for n in session.robot.snapshot.nodes] == ["/good", "/good_2"])


STARTER = """
import threading

import rclpy
from rclpy.node import Node


def main():
    rclpy.init()
    starter = Node("starter")
    threading.Thread(target=threading.Event().wait, daemon=True).start()
    rclpy.spin(starter)
"""


@pytest.mark.real_time
@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="there a program is a process")
def test_a_program_is_interrupted_only_once_the_thread_that_it_starts_runs(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # CPython before 3.12 raises it in the new thread instead, and its starter waits for ever.
    starts, asked, is_raised = threading.Event(), threading.Event(), threading.Event()
    order: list[str] = []
    start_new_thread, raise_in = threading._start_new_thread, interrupt.raise_in  # type: ignore[attr-defined]

    def start_slowly(*args: Any, **options: Any) -> Any:
        if threading.current_thread().name == "/starter":
            starts.set()
            asked.wait(10)
            is_raised.wait(0.3)
            order.append("started")
        return start_new_thread(*args, **options)

    def note(thread: threading.Thread, *error: Any) -> None:
        order.append("interrupted")
        is_raised.set()
        raise_in(thread, *error)

    monkeypatch.setattr(threading, "_start_new_thread", start_slowly)
    monkeypatch.setattr("archo_tui.user_code.thread.raise_in", note)
    with running(written("starter.py", STARTER)) as session:
        assert starts.wait(10)
        asked.set()
        assert session.host.stop_node("/starter").text == "/starter stopped"
    assert order[:2] == ["started", "interrupted"]
