"""Managed nodes: their states, and transitions by verb and from the node's dialog."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.outcome import Code, data_of
from archo_tui.robot.state.graph import NodeInfo
from tests.robots.managed import Navigator
from tests.support.console import Console, console
from tests.support.plain import plain
from tests.support.robot import making

FILE = Path(__file__).with_name("managed.yaml")


@asynccontextmanager
async def managed(**options: Any) -> AsyncIterator[tuple[Console, Navigator]]:
    """The console, and the managed node."""
    made: list[Navigator] = []
    async with console(
        robot=FILE, node_makers=[making(made, Navigator)], wait=False, **options
    ) as op:
        await op.until("navigator unconfigured")
        await op.until(lambda: "move_to_shelf" in op.app.view.snapshot.offered)
        yield op, made[0]


async def change(op: Console, *words: str) -> None:
    """Have the node make transitions that ask nothing."""
    for word in words:
        outcome = await op.session.station.robot.change_lifecycle("/navigator", word)
        assert outcome.code is Code.DONE


async def test_its_transitions_are_buttons_in_its_dialog_and_ask() -> None:
    async with managed() as (op, _):
        await op.press("5", "enter")
        await op.until("lifecycle   unconfigured")
        await op.until("Configure")
        assert "Activate" not in op.text
        await op.press("tab", "enter")
        await op.until("/navigator serves STOP (emergency_stop). Configure /navigator?")
        await op.press("right", "enter")
        await op.until("lifecycle   inactive")
        await op.until("Activate")
        await op.press("escape")
        await op.until("lifecycle navigator configure: navigator is inactive")


async def test_two_who_ask_for_its_transitions_are_both_answered() -> None:
    async with managed() as (op, _):
        robot, go_on = op.session.station.robot, threading.Event()
        robot.thread.submit(go_on.wait)  # So that both questions leave before an answer comes.
        asked = asyncio.gather(*(robot.lifecycle_transitions("/navigator") for _ in range(2)))
        await asyncio.sleep(0)
        go_on.set()
        await op.until(asked.done)
        first, second = asked.result()
        assert "configure" in first
        assert first == second
        lifecycle, station = op.app.verbs["lifecycle"], op.session.station
        values = await lifecycle.prepare(station, {"node": "navigator"})  # A short name.
        found = {"node": "/navigator", "state": "unconfigured"}
        assert data_of(await lifecycle.run(station, values)) == found


async def test_what_the_node_rejects_is_said() -> None:
    async with managed() as (op, node):
        await change(op, "configure")
        node.may_activate = False
        outcome = await op.session.station.robot.change_lifecycle("/navigator", "activate")
        assert outcome == (Code.REFUSED, "navigator rejected it, and is inactive")
        outcome = await op.session.station.robot.change_lifecycle("/navigator", "deactivate")
        assert outcome.code is Code.REFUSED
        assert outcome.text.startswith("not possible in inactive: there are ")
        assert (await op.session.station.robot.change_lifecycle("/navigator", "shutdown")).ok
        outcome = await op.session.station.robot.change_lifecycle("/navigator", "activate")
        assert outcome == (Code.REFUSED, "not possible in finalized: there are none")


async def test_its_state_is_shown_and_a_transition_under_a_running_goal_asks() -> None:
    async with managed() as (op, node):
        await op.press("g", "3", "enter")
        await op.until("/navigator is unconfigured")  # It names the inactive server.
        await change(op, "configure")
        await op.until("○ navigator inactive")
        await change(op, "activate")
        await op.until("● navigator active")
        await op.press("escape", "g", "3", "enter")
        await op.until("12.0 m left")
        verb = op.app.verbs["lifecycle"]
        question = verb.question(
            op.session.station, {"node": "/navigator", "transition": "deactivate"}
        )
        assert question is not None
        assert "and /navigator serves move_to_shelf" in question.text
        node.arrive()
        await op.until("✓ ARRIVED")


async def test_in_words_it_is_shown_and_asked() -> None:
    def unmanaged(**options: Any) -> Node:
        return Node("unmanaged", **options)

    _, said = await plain(
        "lifecycle navigator\nlifecycle navigator configure\nlifecycle nav\nlifecycle unmanaged\n",
        robot=FILE,
        node_makers=[Navigator, unmanaged],
    )
    assert "navigator is unconfigured: it can configure, shutdown" in said
    assert "serves STOP (emergency_stop)" in said
    assert "no node /nav is on the graph\n" in said
    assert "/unmanaged is not a managed node\n" in said


async def test_a_node_that_no_longer_answers_is_not_shown_as_active() -> None:
    async with managed() as (op, node):
        await change(op, "configure", "activate")
        await op.until("● navigator active")
        node.hang()
        await op.until(", no answer")
        assert "○ navigator" in op.text
        station = op.session.station
        told = asyncio.ensure_future(op.app.verbs["lifecycle"].run(station, {"node": "/navigator"}))
        await op.until(told.done)
        outcome = told.result()
        assert outcome.code is Code.TIMEOUT
        assert outcome.text.startswith("no answer from navigator")


async def test_states_in_quick_succession_leave_the_buttons_of_the_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with managed() as (op, _):
        robot, go_on, asked = op.session.station.robot, asyncio.Event(), []
        answers = iter([("configure",), ("cleanup", "activate"), ("deactivate", "shutdown")])

        async def describe(node: str) -> NodeInfo:
            transitions = next(answers)
            asked.append(node)
            if len(asked) > 1:
                await go_on.wait()
            return NodeInfo(transitions=transitions)

        monkeypatch.setattr(robot, "describe", describe)
        await op.press("5", "enter")
        await op.until("Configure")
        await change(op, "configure")
        await op.until(lambda: len(asked) == 2)
        await change(op, "activate")
        await op.until(lambda: len(asked) == 3)
        go_on.set()
        await op.until("Deactivate")
        assert "Cleanup" not in op.text


async def test_no_call_makes_a_transition_without_the_question() -> None:
    _, said = await plain(
        "call /navigator/change_state transition.id=1\nlifecycle navigator\n",
        robot=FILE,
        node_makers=[Navigator],
    )
    assert "is a part of the lifecycle of /navigator: type lifecycle /navigator" in said
    assert "navigator is unconfigured" in said
    async with managed() as (op, _):
        await op.press("C", *"change_state", "enter")
        await op.until("/navigator: type lifecycle /navigator")
