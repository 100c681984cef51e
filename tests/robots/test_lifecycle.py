"""Managed nodes: their states, and transitions by verb and from the node's dialog."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import EmergencyStop
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.task import Future

from archo_tui.robot.outcome import Code, data_of
from archo_tui.robot.state.graph import NodeInfo
from tests.support.console import Console, console_with
from tests.support.plain import plain
from tests.support.ros import begin
from tests.support.stand_in import Drive


class Navigator(LifecycleNode):
    """It takes goals while it is active; `may_activate` is what it answers to activate."""

    def __init__(self, **options: Any) -> None:
        super().__init__("navigator", **options)
        self.is_active, self.may_activate = False, True
        self.create_service(EmergencyStop, "emergency_stop", lambda _, response: response)
        self.drive = Drive(
            self,
            MoveToShelf,
            "move_to_shelf",
            "distance_remaining",
            way=12.0,
            step=0.0,
            accepts=lambda _: self.is_active,
            result=lambda how: {"success": how == "succeed"},
        )

    def hang(self) -> None:
        """Answer no question about the state any more."""
        for service in list(self.services):
            if service.srv_name.endswith(("get_state", "get_available_transitions")):
                service.callback = self._never

    async def _never(self, _: Any, response: Any) -> Any:
        await Future(executor=self.executor)
        return response

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        if not self.may_activate:
            return TransitionCallbackReturn.FAILURE
        self.is_active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.is_active = False
        return super().on_deactivate(state)


FILE = Path(__file__).with_name("managed.yaml")


@asynccontextmanager
async def managed() -> AsyncIterator[tuple[Console, Navigator]]:
    """The console, and the managed node."""
    async with console_with(Navigator, "move_to_shelf", robot=FILE) as (op, node):
        await op.until("navigator unconfigured")
        yield op, node


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


async def test_who_asks_for_its_transitions_is_answered_whatever_it_says() -> None:
    async with managed() as (op, node):
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
        await change(op, "configure")
        node.may_activate = False  # What it rejects is said.
        outcome = await robot.change_lifecycle("/navigator", "activate")
        assert outcome == (Code.REFUSED, "navigator rejected it, and is inactive")
        outcome = await robot.change_lifecycle("/navigator", "deactivate")
        assert outcome.code is Code.REFUSED
        assert outcome.text.startswith("not possible in inactive: there are ")
        await change(op, "shutdown")
        outcome = await robot.change_lifecycle("/navigator", "activate")
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
        begin(node, node.drive.end, "succeed")
        await op.until("✓ ARRIVED")
        node.hang()  # It is not shown as active any more.
        await op.until(", no answer")
        assert "○ navigator" in op.text
        told = asyncio.ensure_future(verb.run(op.session.station, {"node": "/navigator"}))
        await op.until(told.done)
        outcome = told.result()
        assert outcome.code is Code.TIMEOUT
        assert outcome.text.startswith("no answer from navigator")


async def test_in_words_it_is_shown_and_asked_and_no_call_goes_round_the_question() -> None:
    _, said = await plain(
        "lifecycle navigator\nlifecycle navigator configure\nlifecycle nav\nlifecycle unmanaged\n"
        "call /navigator/change_state transition.id=1\nlifecycle navigator\n",
        robot=FILE,
        node_makers=[Navigator, partial(Node, "unmanaged")],
    )
    assert said.count("navigator is unconfigured: it can configure, shutdown") == 2
    assert "serves STOP (emergency_stop)" in said
    assert "no node /nav is on the graph\n" in said
    assert "/unmanaged is not a managed node\n" in said
    assert "is a part of the lifecycle of /navigator: type lifecycle /navigator" in said
    async with managed() as (op, _):
        await op.press("C", *"change_state", "enter")
        await op.until("/navigator: type lifecycle /navigator")
        await op.until("navigator unconfigured")


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
