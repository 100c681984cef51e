"""Keys and clicks that come in a burst do what they do with pauses between them.

A model test: the same random sequence is pressed with pauses, then in one write or with gaps of
some milliseconds, on one console over a robot that stands still. Both times the console must end in
the same state, and the robot must have been asked for the same.

A walk of keys, clicks, pastes and sizes over all screens: nothing breaks or sticks, STOP answers.
"""

from __future__ import annotations

import asyncio
import random
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import Any

import pytest
from textual import events, widgets
from textual.app import App
from textual.geometry import Size
from textual.message import Message
from textual.widgets import Input

from archo_tui.robot.goals.queue import GoalQueue
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.commands import registry
from archo_tui.screen.dialog import Dialog
from archo_tui.screen.keyed_app import HELD
from archo_tui.screen.terminal.stop_marks import dispatch
from archo_tui.screen.widgets.field import Field
from archo_tui.screen.widgets.panel import Panel
from archo_tui.screen.widgets.rows import Rows
from archo_tui.station import save_load
from tests.support.archo import ARCHO
from tests.support.clock import NOW
from tests.support.console import click, key_event, send
from tests.support.front import front, reset_main
from tests.support.quiet import Quiet
from tests.support.states import ARRIVED, STATES
from tests.support.stub import StandingClock, StubRobot, sized, stub_station

GAPS = (0.0, 0.002, 0.01, 0.03, 0.1)  # s
_SIZE = (160, 48)  # with all panels
_ACTIONS = {"/move_to_shelf": ("archo_interfaces/action/MoveToShelf",)}
_SERVICES = {"/reset_encoder": ("archo_interfaces/srv/ResetEncoder",)}
_LETTERS = "acdeklnqrsuyARGC148"
_LATER = NOW + 1e6  # s
_TURNS = 7  # of the loop that an answer of the robot takes

# what people type: keys by their names, one after the other
_PIECES = """
g 1 enter | g 3 1 enter | 2 enter | 7 | enter | g 1 2 backspace 4 enter | g 9 9 enter |
4 slash m a x enter | 4 slash l o w enter enter | 4 slash s p enter | escape | slash z |
ctrl+u 1 full_stop 5 enter | ctrl+u 2 1 enter | ctrl+u x enter escape | 4 down enter |
6 slash l o w enter | 6 slash m a x enter enter | 6 down | 6 e | l | h | escape enter |
question_mark | f1 e n c | ctrl+p s p enter | ctrl+p r e s e t enter | ctrl+p g o enter |
ctrl+p n o r d enter | ctrl+p h i s t enter | ctrl+p | ctrl+p down enter | A | A s |
G m o v e enter | 5 enter | C r e s enter enter | G enter 5 enter | ctrl+s | escape | R y |
R n | R right enter | R tab enter | r | c | d | full_stop | 1 | 8 down enter | 3 |
tab right enter | tab | shift+tab | up | down | left | end | home | ctrl+w | ctrl+c | space |
n | y | k | a | s | plus | backspace | delete | g tab down enter
""".replace("\n", " ").split("|")


# that once drove to 12, set another parameter, and forgot a goal
_STORIES = ["g 1 enter 2 enter", "4 slash m a x enter enter ctrl+u 1 full_stop 5 enter g 7 enter"]


class StandingRobot(StubRobot):
    """A robot that takes everything it is asked for, and stands still."""

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        self.asked: list[tuple[str, str]] = []
        self._numbers = count(1)
        self._drives = snapshot.goal is not None and snapshot.goal.is_running

    def __getattr__(self, verb: str) -> Any:
        async def ask(*values: Any, **_: Any) -> Outcome:
            if verb != "emergency_stop" and self.stops.gate().is_shut:
                return Outcome(Code.CANCELLED, "not sent")
            if verb == "send" and self.snapshot.is_stopped:
                return Outcome(Code.REFUSED, "stopped")  # the first one, or that holds the queue
            if verb == "cancel" and not self._drives:
                # A burst may cancel a goal before its refusal, or its arrival at once: a robot has
                # no goal to cancel then.
                return Outcome(Code.REFUSED, "no goal is running")
            self.asked.append((verb, repr(values[-1:])))
            for _turn in range(_TURNS):
                await asyncio.sleep(0)
            if verb == "send":
                number = next(self._numbers)
                self.put(self.snapshot._replace(goal=ARRIVED._replace(number=number)))
            return Outcome(Code.DONE, "done")

        return ask if verb not in ("note", "stop_sending_goals") else super().__getattr__(verb)

    def form(self, _: str) -> tuple[TypedField, ...]:
        """The fields of any type."""
        return (TypedField("shelf_number", "int32", 0),)


class Desk:
    """A console and the one who types."""

    def __init__(self, app: ArchoApp, robot: StandingRobot, clock: StandingClock) -> None:
        self.app, self.robot, self._clock = app, robot, clock
        self._snapshot = robot.snapshot
        self._quiet = Quiet(app)

    async def press(self, messages: list[list[Message]], gap: float | None) -> None:
        """Hand on keys and clicks: all in one write, with gaps, or (None) with pauses."""
        writes = [[*chain(*messages)]] if gap == 0.0 else messages
        for write in writes:
            dispatch(write, self.app, self.app.stop_typed, self.app.post_message)
            self._clock.passed += 2 * HELD if gap is None else gap
            if gap is None:
                await self._quiet.settle()
            elif gap:
                await asyncio.sleep(gap)
        await self._quiet.settle()

    async def reset(self) -> None:
        """Bring everything back to what it was at first."""
        app, main = self.app, self.app.main
        self._clock.passed += 2 * HELD
        for _ in range(20):
            if app.screen is main:
                break
            await self.press([[key_event("escape")]], None)
        assert app.screen is main, app.screen
        reset_main(main)
        app._leaves = False
        app.typed.clear()
        app.theme = "textual-dark"
        app.station.goals.queue = GoalQueue()
        app.station.edits.__init__()  # type: ignore[misc]
        app.clear_selection()
        self.robot.put(self._snapshot)
        self.robot.asked.clear()
        await self._quiet.settle()

    @property
    def state(self) -> list[object]:
        """What a person sees and can go on with, and what the robot was asked for."""
        app = self.app
        standing = [s for s in app.screen_stack if not (isinstance(s, Dialog) and s.is_dismissed)]
        found: list[object] = [self.robot.asked[:], app.theme]
        found += [[panel.number for panel in app.main.query(Panel) if panel.has_class("-fills")]]
        for screen in standing:
            focused = screen.focused
            found.append((type(screen).__name__, None if focused is None else focused.id))
            for field in screen.query(Field).results():
                found.append((field.id, field.value, field.selection))
            for rows in screen.query(Rows).results():
                found.append((rows.id, rows.cursor, rows.shows_cursor, str(rows.item)[:40]))
        return found


@asynccontextmanager
async def desk(state: str) -> AsyncIterator[Desk]:
    shown = STATES[state]
    snapshot = shown._replace(  # what was heard never grows old
        actions=_ACTIONS,
        services=_SERVICES,
        battery=shown.battery._replace(received=_LATER),
        motion=replace(shown.motion, received=_LATER),
        nodes=tuple(node._replace(heard=_LATER) for node in shown.nodes),
        message_rates={},
    )
    robot, clock = StandingRobot(snapshot), StandingClock()
    with sized(_SIZE):
        app = ArchoApp(stub_station(robot, clock))
    app.animation_level = "none"
    app.exit = lambda *_, **__: None  # type: ignore[method-assign]  # by the palette
    async with app.run_test(size=_SIZE):
        yield Desk(app, robot, clock)


def sequence(choose: random.Random) -> list[str]:
    """Keys by name, and clicks as `x,y`; none is the same as the one before it."""
    keys: list[str] = []
    for _ in range(choose.randrange(2, 7)):
        if choose.random() < 0.2:
            keys.append(f"{choose.randrange(_SIZE[0])},{choose.randrange(_SIZE[1])}")
        else:
            keys += choose.choice(_PIECES).split()
    return [key for before, key in zip(["", *keys], keys, strict=False) if key != before]


def messages(keys: list[str]) -> list[list[Message]]:
    """What the terminal sends for each of them."""
    sent: list[list[Message]] = []
    for key in keys:
        if "," in key:
            x, y = map(int, key.split(","))
            for kind in (events.MouseDown, events.MouseUp):
                sent.append([kind(None, x, y, 0, 0, 1, False, False, False, x, y)])
        else:
            sent.append([key_event(key)])
    return sent


@pytest.fixture(autouse=True)
def _no_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write no file, and let no button be dead while it shows that it was pressed."""
    monkeypatch.setattr(save_load, "write_atomically", lambda *_: None)
    monkeypatch.setattr(widgets.Button, "_start_active_affect", lambda _: None)


async def compare(seed: int, number: int, gaps: Sequence[float]) -> list[str]:
    """Press random sequences in both ways; returns those whose ends differ."""
    choose, found = random.Random(seed), []
    stories = [(story.split(), gap) for story in _STORIES for gap in (0.0, 0.002)]
    for state in ("normal", "motor stopped"):
        async with desk(state) as it:
            await it.reset()
            stop = it.app.main.query_one("#stop").region
            chosen = [(sequence(choose), choose.choice(gaps)) for _ in range(number // 2)]
            for keys, gap in [*(stories if state == "normal" else ()), *chosen]:
                if any("," in k and stop.contains(*map(int, k.split(","))) for k in keys):
                    continue
                await it.reset()
                await it.press(messages(keys), None)
                wanted = it.state
                await it.reset()
                await it.press(messages(keys), gap)
                if it.state != wanted:
                    differs = [
                        pair for pair in zip(wanted, it.state, strict=False) if pair[0] != pair[1]
                    ]
                    found.append(f"{state}, gap {gap} s: {' '.join(keys)}\n   {differs[:3]}")
    return found


async def stop_amid_keys(seed: int, number: int, gaps: Sequence[float]) -> None:
    """Press STOP behind random sequences and amid what is typed for a dialog."""
    choose = random.Random(seed)
    for state, openers in (
        ("normal", ("ctrl+p", "G", "C")),
        ("motor stopped", ("R", "ctrl+p")),
        ("motor moving", ("r", "ctrl+p")),  # which asks first while a goal runs
    ):
        async with desk(state) as it:
            for _ in range(number // 3):
                await stop_behind(it, choose, choose.choice(gaps))
                await stop_amid_a_dialog(it, choose, choose.choice(gaps), choose.choice(openers))


async def stop_behind(it: Desk, choose: random.Random, gap: float) -> None:
    """The robot is asked for nothing after a STOP."""
    keys = [*sequence(choose), "ctrl+x"]
    await it.reset()
    await it.press(messages(keys), gap)
    asked = [verb for verb, _ in it.robot.asked]
    assert asked[-1:] == ["emergency_stop"], (gap, keys, asked)
    assert gap or {*asked} == {"emergency_stop"}, (gap, keys, asked)


async def stop_amid_a_dialog(it: Desk, choose: random.Random, gap: float, opener: str) -> None:
    """None of what was typed for it acts anywhere else; a cancel does."""
    before_it = choose.sample("abdehk", choose.randrange(3))  # which is no answer
    behind = choose.sample([*_LETTERS, "enter", "tab", "down", "space"], 7)
    keys = [opener, *before_it, "ctrl+x", *behind]
    await it.reset()
    before = it.state
    await it.press(messages([*keys, "ctrl+c"]), gap)
    drives = it.robot.snapshot.running_goal is not None
    wanted = ["emergency_stop", *(["cancel"] if drives else [])]
    assert [verb for verb, _ in it.robot.asked] == wanted, (gap, keys)
    assert it.state[1:] == before[1:], (gap, keys)
    assert not it.app._leaves, (gap, keys)


async def test_a_burst_ends_as_the_same_keys_do_with_pauses() -> None:
    found = await compare(seed=3, number=5, gaps=GAPS[:3])
    assert not found, "\n".join(found)


async def test_nothing_typed_before_a_stop_or_for_a_dialog_that_it_closed_acts() -> None:
    await stop_amid_keys(seed=4, number=6, gaps=GAPS[:3])


@pytest.mark.night
@pytest.mark.parametrize("_part", range(3))
async def test_many_stops_behind_and_amid_keys(_part: int) -> None:
    await stop_amid_keys(random.randrange(10**6), number=50, gaps=(*GAPS, 0.3))


@pytest.mark.night
@pytest.mark.parametrize("_part", range(10))
async def test_many_bursts_end_as_the_same_keys_do_with_pauses(_part: int) -> None:
    seed = random.randrange(10**6)
    found = await compare(seed, number=50, gaps=GAPS)
    assert not found, f"seed {seed}:\n" + "\n".join(found)


COMMANDS = registry(ARCHO)
_WALKED_KEYS = sorted(
    {command.key for command in COMMANDS if command.key}
    | set("0123456789azAZ .-") | {"tab", "shift+tab", "escape", "enter", "up", "down", "left"}
    | {"right", "pageup", "pagedown", "home", "end", "backspace", "delete", "ctrl+home", "ctrl+end"}
)  # fmt: skip
_LEAVING = {"ctrl+q", "q", "ctrl+z"}  # end the walk
_EACH = 50  # keys between two looks at the invariants
_PASTES = ("12", "a\nb", "\x1b[31m", "9" * 300, "x: [", "  7 ")
_SIZES = ((80, 24), (120, 36), (160, 48), (79, 23), (200, 60), (40, 10), (20, 5), (1, 1))
_WALKED = Size(100, 30)


def something_else(app: App[Any], choose: random.Random) -> None:
    """A click, a paste or another size of the terminal."""
    what = choose.randrange(4)
    if what == 0:
        app.post_message(events.Paste(choose.choice(_PASTES)))
    elif what == 1:
        size = Size(*choose.choice(_SIZES))
        app.post_message(events.Resize(size, size))
    else:
        click(app, choose.randrange(app.size.width), choose.randrange(app.size.height))


async def walk(seed: int, keys: int) -> None:
    """Press keys at random; the state of the robot changes at random as well."""
    choose = random.Random(seed)
    names = sorted(set(STATES) - {"many parameters"})
    stops: list[int] = []

    async def stop() -> Outcome:
        stops.append(1)
        return Outcome(Code.DONE, "stopped")

    possible = [key for key in _WALKED_KEYS if key not in _LEAVING and key != "ctrl+x"]
    async with front(size=(_WALKED.width, _WALKED.height)) as it:
        app, robot, press = it.app, it.robot, it.press
        robot.emergency_stop = stop
        app.exit = lambda *_, **__: None  # type: ignore[method-assign]  # by a click, or the palette
        app.action_suspend_process = lambda: None  # type: ignore[method-assign]
        for number in range(keys // _EACH):
            robot.put(STATES[choose.choice(names)])
            pressed = [choose.choice(possible) for _ in range(_EACH)]
            for key in pressed:
                send(app, key)
                if choose.random() < 0.1:
                    something_else(app, choose)
                    await asyncio.sleep(0)  # it comes while what was before is being done
            await it.settle()
            app.clear_notifications()
            app.post_message(events.Resize(_WALKED, _WALKED))
            where = f"seed {seed}, after {number * _EACH + _EACH} keys, the last: {pressed[-20:]}"
            robot.put(STATES["normal"])
            stops.clear()
            await press("ctrl+x")
            assert stops == [1], where
            assert app.is_running, where
            for _ in range(10):  # no dialog sticks
                if app.screen is app.main:
                    break
                await press("escape")
            assert app.screen is app.main, where
            if isinstance(app.focused, Input):
                await press("escape")
            assert app.focused is not None, where
            assert not isinstance(app.focused, Input), where


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files may be saved on the way."""
    monkeypatch.chdir(tmp_path)


async def test_a_walk_of_keys_at_random() -> None:
    await walk(seed=7, keys=100)


@pytest.mark.night
@pytest.mark.parametrize("_part", range(10))
async def test_a_long_walk_of_keys_at_random(_part: int) -> None:
    await walk(seed=random.randrange(10**6), keys=2000)
