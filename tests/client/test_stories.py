"""The same stories by keys, by lines, from a shell and from Python: the outcomes are the same.

What is refused is said in the same words to lines, shell and Python.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import NamedTuple

import pytest

import archo_tui
from archo_tui.client.errors import ERRORS, NotDone, Refused
from archo_tui.client.protocol import EXITS
from archo_tui.console.typing import Input
from archo_tui.station.station import Station
from tests.support.console import FAST, LONG, console
from tests.support.night import corners
from tests.support.shells import heard, own_socket, served, typed, until

pytestmark = pytest.mark.real_time


class Step(NamedTuple):
    """One thing that an operator does."""

    words: str
    keys: str
    outcomes: tuple[str, ...]  # verb and code of what comes of it
    waits: bool = True  # a shell or a program waits for the end of the goals


DRIVEN = ("go accepted", "go arrived")
GO = Step("go 12", "g 1 2 enter", DRIVEN)
STOP = Step("stop", "ctrl+x", ("stop done",))
RELEASE = Step("release --yes", "R y", ("release done",))
REFUSED = ("go refused",)
# Not waited for: what a client that waits has queued goes when the client ends.
QUEUED = Step("go 12 99 7", "g 1 2 space 9 9 space 7 enter", (*DRIVEN, *REFUSED), waits=False)
STORIES: dict[str, tuple[list[Step], str]] = {
    "nothing to release": ([Step("release --yes", "R", ())], ""),
    "the encoder is reset": ([Step("reset", "r", ("reset done",))], ""),
    "a goal arrives": ([GO], "arrived"),
    "two in one line arrive": (
        [Step("go 12 7", "g 1 2 space 7 enter", DRIVEN + DRIVEN)],
        "arrived",
    ),
    "no such shelf": ([Step("go 99", "g 9 9 enter", REFUSED)], "refused"),
    "what waits behind a refusal is held, and left out": (
        [
            QUEUED,
            Step("skip", "k", ("skip done",)),
            Step("continue", "n", ()),
        ],
        "refused",
    ),
    "nothing is left of a list whose first goal is refused": (
        [
            Step("go 99 7", "g 9 9 space 7 enter", REFUSED),
            Step("continue", "n", ()),
        ],
        "refused",
    ),
    "what is held is continued": (
        [
            QUEUED,
            Step("continue", "n", ("continue done", *DRIVEN)),
        ],
        "arrived",
    ),
    "a stopped robot goes nowhere, released it goes": (
        [STOP, GO._replace(outcomes=REFUSED), RELEASE, GO],
        "arrived",
    ),
}


def outcomes(station: Station) -> list[str]:
    """Verb and code of all that was done."""
    records = [
        event.audit_record
        for event in station.robot.snapshot.events
        if event.audit_record is not None
    ]
    return [f"{record.verb} {record.code.value}" for record in records]


def is_over(station: Station, wanted: list[str]) -> bool:
    """True when so much was done, and nothing goes on."""
    snapshot = station.robot.snapshot
    stops = [said for said in wanted if said in (*STOP.outcomes, *RELEASE.outcomes)]
    stopped = bool(stops) and stops[-1] == STOP.outcomes[0]
    going = snapshot.running_goal is not None or station.queue.is_going
    there = snapshot.motion.stopped is not None and len(snapshot.offered) >= 7
    return there and not going and (snapshot.motion.stopped is stopped)


async def tell(station: Station, do: Callable[[Step], Awaitable[object]]) -> None:
    """Go through all stories, one after the other, at one console."""
    wanted: list[str] = []

    def is_done() -> bool:
        return len(outcomes(station)) >= len(wanted) and is_over(station, wanted)

    for name, (steps, end) in STORIES.items():
        await until(is_done, lambda: str(outcomes(station)))
        for step in steps:
            await do(step)
            wanted += step.outcomes
            await until(is_done, lambda: str(outcomes(station)))
            assert outcomes(station) == wanted, name
        goal = station.robot.snapshot.goal
        assert ("" if goal is None or goal.code is None else goal.code.value) == end, name


async def test_by_keys(unlimited: Path) -> None:
    async with console(*FAST, robot=unlimited) as op:

        async def do(step: Step) -> None:
            await op.press(*step.keys.split())

        await tell(op.session.station, do)


async def test_by_lines(unlimited: Path) -> None:
    async with served(robot=unlimited, ros_args=FAST) as person:

        async def do(step: Step) -> None:
            person.type(f"{step.words}\n")

        await tell(person.station, do)


@pytest.mark.parametrize("screen", corners([False], [True]), ids=["plain", "screen"])
async def test_from_a_shell(screen: bool, unlimited: Path) -> None:
    async def do(step: Step) -> None:
        waits = ["--wait"] if step.words.startswith("go") and step.waits else []
        said = await typed(*step.words.split(), *waits)
        if step.outcomes[-1:] == ("go arrived",) and waits:
            assert re.fullmatch(r"accepted\nArrived at shelf \d+\n", said.err), said
        is_refused = step.waits and any("refused" in outcome for outcome in step.outcomes)
        good = bool(step.outcomes) and not is_refused
        assert said.code == (0 if good else 1), said

    if screen:
        async with console(*FAST, robot=unlimited, remote=True) as op:
            await op.until(own_socket)
            await tell(op.session.station, do)
    else:
        async with served(robot=unlimited, ros_args=FAST) as person:
            await tell(person.station, do)


async def test_from_python(unlimited: Path) -> None:
    async with served(robot=unlimited, ros_args=FAST) as person:
        with await asyncio.to_thread(archo_tui.connect) as robot:

            def run(step: Step) -> None:
                with contextlib.suppress(NotDone):
                    robot.do(*step.words.split(), wait=step.words.startswith("go") and step.waits)

            async def do(step: Step) -> None:
                await asyncio.to_thread(run, step)

            await tell(person.station, do)


SET = "set motor_controller"
REFUSALS = [  # what is typed, the code of its outcome, and why
    ("go 99", "misuse", "go: Shelf: at most 40, not 99"),
    ("go there", "misuse", "go: Shelf: not a whole number: there"),
    ("go", "misuse", "go: Shelf: type a value"),
    ("jump", "misuse", "no command 'jump' ("),
    ("relaese", "misuse", "no command 'relaese' (nearest: release)"),
    ("cancel", "refused", "cancel: no goal is running"),
    ("release", "refused", "release: the robot is not stopped"),
    ("undo", "refused", "undo: nothing to undo"),
    ("set", "misuse", "set: needs [NODE] NAME VALUE"),
    ("set motor_controller 1", "misuse", "set: motor_controller is a node: needs [NODE] NAME"),
    (
        "set use_sim_time true",
        "misuse",
        "set: use_sim_time is in several nodes, so say in which: battery_monitor, dashboard, motor",
    ),
    ("set battery_monitor drain_min 50", "refused", "set: drain_min 50"),
    (f"{SET} max_speed 9", "misuse", "set: motor_controller max_speed: allowed 0.05 .. 2, not 9"),
    (f"{SET} max_speed nan", "misuse", "set: motor_controller max_speed: not a finite number: nan"),
    (
        f"{SET} ticks_per_revolution 5",
        "misuse",
        "set: motor_controller ticks_per_revolution: ticks_per_revolution is read-only",
    ),
    (
        "get motor_controller max_sped",
        "misuse",
        "get: /motor_controller has no parameter max_sped (nearest: max_speed)",
    ),
    ("continue", "refused", "continue: no queue is held"),
    ("wait", "misuse", "wait: needs idle, arrived, ready, stopped, left N or battery N"),
    ("wait arrived", "refused", "wait: no goal is running"),
    ("wait battery 101", "misuse", "wait: battery: from 0 to 100 percent, not 101"),
]


async def test_what_cannot_be_done_is_said_alike_by_lines_shell_and_python() -> None:
    async with served(ros_args=FAST) as person:
        assert (await typed("wait", "ready")).code == 0
        with await asyncio.to_thread(archo_tui.connect) as robot:
            for words, code, why in REFUSALS:
                person.type(f"{words}\n")
                await heard(person, f"failed: {why}")
                said = await typed(*words.split())
                assert (said.code, said.out) == (EXITS.get(code, 1), ""), said
                assert said.err.startswith("archo-tui: ")
                assert why in said.err.replace("archo-tui --help", "help"), said
                with pytest.raises(NotDone) as raised:
                    await asyncio.to_thread(robot.do, *words.split())
                assert type(raised.value) is ERRORS.get(code, Refused), words
                assert raised.value.code == code
                assert why.removeprefix(f"{words.split()[0]}: ") in str(raised.value)
        assert "Traceback" not in person.said
        assert await person.end() == 1


ENDED = "the goal that was asked about has ended"


async def test_a_question_closes_with_its_goal_and_the_line_read_meanwhile_is_carried_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served(ros_args=LONG, at_terminal=True) as person:
        person.type("go 12\n")
        await heard(person, "MOVING to 12")
        person.type("reset\n")
        await heard(person, "shelf 12. Reset encoder now? [y/N]")
        with monkeypatch.context() as patch:
            patch.setattr(Input, "is_quiet", False)  # More may be behind it.
            person.type("nodes\n")
            await until(lambda: not person._plain._input._waiting)
            assert (await typed("cancel")).code == 0
            await heard(person, f"failed: reset: {ENDED}")
        await heard(person, "motor_controller up")
        assert await person.end() == 1
        assert "reset encoder" not in person.said
