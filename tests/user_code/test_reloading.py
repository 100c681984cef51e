"""Nodes of the user's own are restarted whenever their file is saved."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from textual.widgets import Static

from archo_tui.robot.state.events import Event
from archo_tui.session.session import Session
from archo_tui.user_code.hosted import HostedThread
from tests.support import chosen
from tests.support.console import Console, console
from tests.support.plain import operated, typing
from tests.support.quiet import until
from tests.user_code.support import running as hosting
from tests.user_code.support import written

TALKER = """
from rclpy.node import Node

class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.declare_parameter("gain", 1.0)
        self.create_timer(0.2, self.tick)

    def tick(self):
        {body}
"""


def talker(body: str) -> str:
    return TALKER.format(body=body)


def says(word: str) -> str:
    return talker(f"self.get_logger().warning({word!r})")


@asynccontextmanager
async def running(file: Path, *ros_args: str, only: bool = True) -> AsyncIterator[Console]:
    async with console(*ros_args, node_files=[file], only=only, wait=False) as op:
        await op.until(" talker ")
        yield op


async def save(op: Console, file: Path, text: str) -> None:
    """Save it, and have it reloaded at once, as it soon would be."""
    file.write_text(text)
    await asyncio.to_thread(op.session._watch.watched[0][1])
    op.app.update_screen()


@pytest.fixture(autouse=True)
def _by_hand(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """Only what `save` says is read again, unless the test is about the watching."""
    if not request.node.get_closest_marker("real_time"):
        monkeypatch.setattr("archo_tui.user_code.watch.FileWatcher.start", lambda self: None)


@pytest.mark.real_time
async def test_a_saved_file_runs_by_itself_and_what_is_wrong_with_it_is_said(here: Path) -> None:
    file = here / "talker.py"
    file.write_text(says("first words"))
    async with running(file) as op:
        await op.until("first words")
        await op.until("talker.py, saved ")
        file.write_text("import nosuchpackage\n" + says("other words"))
        await op.until("✗ talker")
        await op.until("not restarted: line 1:")
        await op.until(lambda: event_with(op, "does not run"))
        event = event_with(op, "does not run")
        assert event is not None
        assert f"{file}:1: ModuleNotFoundError: No module named 'nosuchpackage'" in event.text
        assert f"looked for it in {Path.cwd()}" in event.text
        before = op.app.view.snapshot.events[-1]
        await op.until(lambda: op.app.view.snapshot.events[-1] != before)  # it still talks
        file.write_text(says("other words").replace('"gain", 1.0', '"gain", goal'))
        await op.until("crashed: line 7:")
        await op.until(lambda: event_with(op, "NameError"))
        event = event_with(op, "NameError")
        assert event is not None
        assert "name 'goal' is not defined, in: self.declare_parameter" in event.text
        await op.press("5", "home", "enter")
        await op.until("Traceback")
        # the file is named by its whole path, which may be wrapped anywhere
        assert any("talker.py" in str(shown.content) for shown in op.app.screen.query(Static))
        await op.press("escape")
        file.write_text(says("well again"))
        await op.until("well again")
        await op.until("talker.py was saved: /talker restarted")
        await op.until("● talker")


def parameter(session: Session, name: str) -> object:
    """A parameter of the only node of the only program."""
    (program,) = session.host.programs
    (node,) = program.ask({"ask": "nodes"})["nodes"]
    return node["parameters"][name]


def event_with(op: Console, text: str) -> Event | None:
    return next((e for e in op.app.view.snapshot.events if text in e.text), None)


@pytest.mark.waits
async def test_info_of_ones_own_nodes_is_seen_without_asking(here: Path) -> None:
    file = here / "talker.py"
    own = "self.get_logger().info('own words'); self.get_logger().get_child('arm').info('raised')"
    file.write_text(talker(own))
    async with running(file, only=False) as op:
        await op.press("6")
        await op.until("own words")
        await op.until("raised")
        assert any(event.level == "INFO" for event in op.app.view.snapshot.events)
        assert "·  dashboard: " not in op.text
        await op.press("l")
        await op.until("·  dashboard: ")
        await op.press("l", "l")  # ERROR and above
        await op.until(lambda: "own words" not in op.text)


async def test_info_of_ones_own_nodes_is_told_by_plain_with_its_line_feeds(here: Path) -> None:
    file = here / "talker.py"
    file.write_text(talker(r"self.get_logger().info('own words\na: 2 b: 3')"))
    async with operated(node_files=[file]) as typed:
        await typed.until("INFO talker: own words\n         a: 2 b: 3")
        assert "INFO dashboard" not in typed.said


@pytest.mark.skipif("chosen.ENGINE == 'ros2'", reason="there a node comes back seconds later")
async def test_what_was_set_is_set_again_and_what_was_undone_is_not(here: Path) -> None:
    file = written("talker.py", says("first words"))
    with hosting(file) as session:
        async with typing(session.station) as person:
            await until(lambda: "gain" in parameter_names(session))
            for typed, value in (("set talker gain 2.5", 2.5), ("undo", 1.0)):
                person.type(f"{typed}\n")
                await person.until(f"gain is {value}, was ")
                file.write_text(says(f"after {typed}"))
                await asyncio.to_thread(session._watch.watched[0][1])
                await person.until(f"after {typed}")
                assert parameter(session, "gain") == value
                await until(
                    lambda: "/talker" in {node.name for node in session.robot.snapshot.nodes}
                )
                person.type("params\n")
                await person.until(f"talker gain {value}")


def parameter_names(session: Session) -> set[str]:
    return {parameter.name for parameter in session.robot.snapshot.parameters}


@pytest.mark.real_time
async def test_a_node_that_hangs_is_said_to_be_stuck_and_replaced(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # while it is waited for it takes all of a core, from other tests too
    monkeypatch.setattr(HostedThread.stop, "__defaults__", (0.5, 0.5))
    file = here / "talker.py"
    file.write_text(says("well"))
    async with running(file) as op:
        endless = 'self.get_logger().warning("from now on")\n        while True: pass'
        await save(op, file, talker(endless))
        await op.until("from now on")
        await op.press("question_mark")
        await op.until("Keys")  # keys answer
        await op.press("escape")
        await save(op, file, says("well again"))
        await op.until("well again")
        # no longer all of a core: it is waited for to its end
        endless = "import time\n        while True: time.sleep(0.01)"
        looping = talker("pass").replace('super().__init__("talker")', endless)
        await save(op, file, looping)
        if chosen.ENGINE == "embedded":
            await op.until("starting: line ")
        await save(op, file, says("well after all"))
        await op.until("well after all")
