"""The screen as a picture, in every state and size. `--update-snapshots` accepts what is seen."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from typing import Any

import pytest

from archo_tui.robot.clients import Requester, on_behalf_of
from archo_tui.robot.goals.queue import GoalQueue, QueuedGoal
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Hosted, Life, Snapshot
from archo_tui.screen.terminal.ascii import in_ascii
from archo_tui.station.alarms import AlarmBoard
from archo_tui.station.history import History
from tests.support.archo import SHELF
from tests.support.clock import TIME
from tests.support.front import Front, differs, front, front_of, reset_main, steady
from tests.support.night import corners
from tests.support.states import ARRIVED, CANCELLED, NORMAL, STATES, ended, past
from tests.support.stub import StandingClock, stub_app

SIZES = {"80x24": (80, 24), "120x36": (120, 36), "160x48": (160, 48)}
SIZES |= {"40x10": (40, 10), "60x20": (60, 20), "120x44": (120, 44), "200x60": (200, 60)}
ALL_SIZES = ("80x24", "120x36", "160x48")


HOSTED = (
    Hosted(
        "/battery_monitor",
        Life.CRASHED,
        "ZeroDivisionError: division by zero",
        'Traceback (most recent call last):\n  File "battery_monitor.py", line 60, in on_timer\n'
        "ZeroDivisionError: division by zero\n",
    ),
    Hosted("/dashboard"),
    Hosted("/dashboard_2", Life.STOPPED),
    Hosted("/motor_controller", Life.STUCK, serves=("/emergency_stop",)),
)


@pytest.fixture(autouse=True)
def _root(monkeypatch: pytest.MonkeyPatch) -> None:
    steady(monkeypatch)


def by_night(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--night"))


class Pictured(Front):
    """In front of a screen of which pictures are compared with those that were accepted."""

    @property
    def text(self) -> str:
        """Nothing: reading draws a dialog before what is behind it."""
        return ""

    async def rest(self) -> None:
        """Let the screen lay out and draw all that it has to."""
        await self.settle()
        await self.tick()  # a new size may have more to say
        self.robot.show_topic()
        await self.settle()

    async def type(self, *keys: str) -> None:
        for key in keys:
            await self.write(key)
            await self.rest()

    async def close(self) -> None:
        """Take down what is open."""
        while self.app.screen is not self.main:
            self.app.pop_screen()
            await self.rest()

    def svg(self) -> str:
        return self.app.export_screenshot(simplify=True)

    def differs(self, request: pytest.FixtureRequest, name: str) -> list[str]:
        size = f"{self.app.size.width}x{self.app.size.height}"
        return differs(request, f"{name} {size}", self.svg())


@asynccontextmanager
async def pictured(
    snapshot: Snapshot,
    size: str = "80x24",
    *keys: str,
    hosted: tuple[Hosted, ...] = (),
    seconds: int = 0,
    queue: Iterable[int] = (),
    in_field: bool = False,
    theme: str = "textual-dark",
) -> AsyncIterator[Pictured]:
    """The screen after those keys; on-delays of alarms have passed.

    `seconds` were seen before; the shelves of the `queue` wait.
    """
    clock = StandingClock()
    clock.passed = -3.0
    app = stub_app(snapshot, clock, hosted, size=SIZES[size], in_field=in_field)
    if queue:  # none of them is sent while another one is on its way
        wanted = [QueuedGoal(SHELF, {"shelf_number": n}) for n in (1, *queue)]
        waits = GoalQueue().seen(snapshot, 0.0, 0).submit(wanted, Snapshot())
        assert waits.coming is not None
        coming = waits.coming._replace(before=99, is_handed_over=True)  # No snapshot shows it.
        app.station.goals.queue = waits._replace(coming=coming, todo=())
    for before in past(seconds):
        app.station.history.observe(*before)
    async with app.run_test(size=SIZES[size]) as pilot:
        it = Pictured(app, pilot)
        app.theme = theme
        clock.passed = 0.0
        app.tick()
        await it.rest()
        await it.type(*keys)
        yield it


async def compare(
    request: pytest.FixtureRequest, name: str, snapshot: Snapshot, *given: str, **options: Any
) -> str:
    """One picture, as accepted."""
    async with pictured(snapshot, *given, **options) as it:
        assert it.differs(request, name) == []
        return it.svg()


async def test_every_state_looks_as_accepted_in_every_size(request: pytest.FixtureRequest) -> None:
    clock, different = StandingClock(), list[str]()
    sizes = ALL_SIZES if by_night(request) else ALL_SIZES[::2]
    options: dict[str, Any] = {"size": SIZES["80x24"], "in_field": True}
    async with front_of(Pictured, STATES["nothing heard yet"], clock, **options) as it:
        for size in sizes:
            await it.resize(*SIZES[size])
            for state, snapshot in STATES.items():
                # no state knows of the one before
                it.app.station._board, it.app.station.history = AlarmBoard(), History()
                for panel in (it.main.nodes, it.main.history, it.main.graph):
                    panel._inputs = None
                for clock.passed in (-3.0, 0.0):  # on-delays of alarms have passed
                    it.robot.put(snapshot)
                await it.rest()
                different += it.differs(request, state)
    assert different == [], "\n".join(different)


KEYS: tuple[tuple[str, list[str], bool], ...] = (  # And whether they open a dialog.
    ("help here", ["4", "question_mark"], True),
    ("nodes hosted", ["5"], False),
    ("traceback", ["5", "home", "enter"], True),
    ("filter", ["4", "slash", *"speed"], False),
    ("filter finds nothing", ["4", "slash", *"warp", "enter"], False),
    ("search", ["6", "slash", *"shelf", "enter"], False),
    ("full screen", ["6", "e"], False),
    ("graph", ["8", "down"], False),
    ("resource", ["8", "end", "enter"], True),
    ("topic", ["8", "home", "down", "enter"], True),
    ("topic plotted", ["8", "home", "down", "enter", "p", "down", "down", "p"], True),
    ("topic opened", ["8", "home", "down", "enter", "end", "up", "enter", "end"], True),
    ("event", ["6", "home", "down", "enter"], True),
    ("save", ["4", "ctrl+s"], True),
    # whose nodes run elsewhere
    ("help", ["f1"], True),
    ("edit", ["4", "home", "down", "down", "enter"], True),
    ("field", ["g", "1", "2"], False),
    ("node", ["5", "home", "down", "down", "enter"], True),
)


async def test_what_keys_open_looks_as_accepted(request: pytest.FixtureRequest) -> None:
    different = list[str]()
    async with pictured(NORMAL, hosted=HOSTED) as it:
        for name, keys, is_dialog in KEYS:
            if name == "help":
                it.app.station.host.states = lambda: ()  # type: ignore[method-assign]
                it.app.station._board, it.main.nodes._inputs = AlarmBoard(), None
            for number, size in enumerate(ALL_SIZES if by_night(request) else ALL_SIZES[:1]):
                await it.close()  # opened again in each size
                await it.resize(*SIZES[size])
                if not number:
                    reset_main(it.main)
                    await it.put(NORMAL)
                await it.rest()
                await it.type(*(keys if is_dialog or not number else ()))
                assert (it.app.screen is not it.main) == is_dialog
                different += it.differs(request, name)
    assert different == [], "\n".join(different)


async def test_a_question_looks_as_accepted(request: pytest.FixtureRequest) -> None:
    different = list[str]()
    async with pictured(STATES["goal cancelling"]) as it:
        for size in ALL_SIZES if by_night(request) else ALL_SIZES[:1]:
            await it.close()
            await it.resize(*SIZES[size])
            await it.rest()
            await it.type("q")
            different += it.differs(request, "question")
    assert different == [], "\n".join(different)


@pytest.mark.parametrize("state", ["normal", "motor stopped"])
async def test_a_large_terminal_looks_as_accepted(
    request: pytest.FixtureRequest, state: str
) -> None:
    options: dict[str, Any] = {"hosted": HOSTED, "seconds": 700, "in_field": True}
    await compare(request, state, STATES[state], "200x60", **options)


ENDED = ARRIVED._replace(time=TIME - 100), CANCELLED._replace(time=TIME - 400)
DRIVEN = STATES["battery low and moving"]._replace(history=ENDED)


async def test_the_history_looks_as_accepted(request: pytest.FixtureRequest) -> None:
    different = list[str]()
    async with pictured(DRIVEN, seconds=700) as it:
        for size in ALL_SIZES if by_night(request) else ALL_SIZES[:1]:
            await it.resize(*SIZES[size])
            for name, *keys in (
                ("history", *["h"] * (size == ALL_SIZES[0])),
                ("history of a minute", "left_square_bracket"),
                ("history of an hour", "right_square_bracket", "right_square_bracket"),
                ("", "left_square_bracket"),
            ):
                await it.rest()
                await it.type(*keys)
                different += it.differs(request, name) if name else []
    assert different == [], "\n".join(different)


async def test_a_topic_stands_beside_the_graph_where_there_is_room(
    request: pytest.FixtureRequest,
) -> None:
    keys = ["8", "home", "down", "enter", "p"]
    await compare(request, "topic beside", NORMAL, "160x48", *keys)


@pytest.mark.parametrize("locale", corners(["C.UTF-8"], ["C"]))
async def test_the_history_stands_beside_the_panels_where_there_is_room(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, locale: str
) -> None:
    monkeypatch.setenv("LC_ALL", locale)
    name = "history in ascii" if locale == "C" else "history beside"
    await compare(request, name, DRIVEN, "160x48", seconds=700, in_field=True)


@pytest.mark.parametrize("size", corners(ALL_SIZES[:1], ALL_SIZES[1:]))
async def test_the_palette_and_the_alarms_look_as_accepted(
    request: pytest.FixtureRequest, size: str
) -> None:
    async with pictured(NORMAL, size, "ctrl+p", hosted=HOSTED) as it:
        assert it.differs(request, "palette") == []
    empty = NORMAL._replace(battery=STATES["battery empty"].battery)
    await compare(request, "alarms", empty, size, "A", hosted=HOSTED)


async def test_the_other_themes_look_as_accepted(request: pytest.FixtureRequest) -> None:
    async with pictured(STATES["battery low and moving"], "120x36", in_field=True) as it:
        for it.app.theme in ("textual-light", "high-contrast"):
            await it.rest()
            assert it.differs(request, it.app.theme.removeprefix("textual-")) == []


async def test_without_utf_8_it_is_all_ascii(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LC_ALL", "C")
    svg = await compare(request, "ascii", STATES["battery low and moving"], in_field=True)
    drawn = "".join(re.findall(r"<text[^>]*>([^<]*)</text>", svg)).replace("&#160;", " ")
    assert drawn.isascii(), set(drawn) - set(map(chr, range(128)))


def test_in_ascii_a_shortened_name_is_seen_and_no_unit_is_a_question_mark() -> None:
    assert in_ascii("start_type_de…ption") == "start_type_de~ption"
    assert in_ascii("90°  0.4 m/s²  3 µs") == "90*  0.4 m/s2  3 us"


async def test_without_colour_every_word_stays(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    svg = await compare(request, "no colour", STATES["battery low and moving"], in_field=True)
    colours = {tuple(c[i : i + 2] for i in (1, 3, 5)) for c in re.findall(r"#[0-9a-f]{6}", svg)}
    grey = {colour for colour in colours if len(set(colour)) == 1}
    assert len(colours - grey) <= 4, colours - grey  # the drawn window's own frame and buttons


@pytest.mark.parametrize("panel", corners(["4"], [*"123568"]))
async def test_a_tiny_terminal_shows_the_focused_panel_between_header_and_footer(
    request: pytest.FixtureRequest, panel: str
) -> None:
    await compare(request, f"tiny panel {panel}", STATES["battery low and moving"], "40x10", panel)


MOVES = STATES["motor moving"]._replace(
    history=(
        ended(20, Phase.REFUSED, "battery empty"),
        ended(9, Phase.ARRIVED, "Arrived at shelf 9"),
        ended(31, Phase.ARRIVED, "Arrived at shelf 31"),
    )
)
LARGE: dict[str, tuple[Snapshot, tuple[int, ...], list[str]]] = {
    "large idle": (NORMAL, (), ["g", "1", "2", "space", "7"]),
    "large with a queue": (MOVES, (7, 3), []),
    "large after ends": (MOVES._replace(goal=MOVES.history[0]), (), []),
}


@pytest.mark.parametrize("name", LARGE)
async def test_a_large_screen_is_filled_as_accepted(
    request: pytest.FixtureRequest, name: str
) -> None:
    snapshot, queue, keys = LARGE[name]
    for size in ("120x44", "160x48") if by_night(request) else ("120x44",):
        await compare(request, name, snapshot, size, *keys, queue=queue, in_field=not keys)


@pytest.mark.night
@pytest.mark.parametrize(
    ("name", "theme"),
    [("ascii", "textual-dark"), ("16 colours", "high-contrast"), ("light", "textual-light")],
)
async def test_a_large_screen_is_filled_as_accepted_elsewhere_too(
    request: pytest.FixtureRequest, name: str, theme: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "ascii":
        monkeypatch.setenv("LC_ALL", "C")
    options: dict[str, Any] = {"queue": (7, 3), "theme": theme, "in_field": True}
    await compare(request, f"large {name}", MOVES, "120x44", **options)


async def test_a_small_terminal_opens_at_the_top_and_odd_sizes_break_nothing(
    request: pytest.FixtureRequest,
) -> None:
    async with pictured(STATES["battery low and moving"], "60x20", in_field=True) as it:
        assert it.differs(request, "small") == []
        svg = it.svg()
        assert "18.0&#160;%&#160;MOVING&#160;to&#160;12" in svg  # in the header
        assert "STOP&#160;" in svg
        for size in ((20, 5), (79, 23), (300, 80)):
            await it.resize(*size)
            assert it.app.is_running


async def test_equal_snapshots_draw_nothing_and_what_comes_at_the_end_is_harmless() -> None:
    async with front() as it:
        lines = list(it.app.query("Line"))
        assert len(lines) > 8
        for line in lines:
            line.update = _must_not  # type: ignore[attr-defined]
        it.robot.put(NORMAL)
        await asyncio.sleep(0)
        for line in lines:
            del line.update  # type: ignore[attr-defined]
        remove = it.app._close_all

        async def close_all() -> None:
            await remove()
            it.app.tick()  # the clock or the robot, a moment too late

        it.app._close_all = close_all  # type: ignore[method-assign]


def _must_not(*_: object, **__: object) -> None:
    raise AssertionError("redrawn for nothing")


@pytest.mark.parametrize("size", corners(ALL_SIZES[:1], ALL_SIZES[1:]))
async def test_what_an_assistant_asks_looks_as_accepted(
    request: pytest.FixtureRequest, size: str
) -> None:
    async with front_of(Pictured, NORMAL, StandingClock(), size=SIZES[size]) as it:
        requester = Requester("AI", "assistant 4711")
        goal = QueuedGoal(SHELF, {"shelf_number": 12})
        it.app.station._frontend = it.app.station.goals.frontend = it.app
        with on_behalf_of(requester):
            it.app.station.approvals.request(goal, "go to shelf 12")
        it.app.update_screen()
        await it.rest()
        assert it.differs(request, "request") == []
        await it.type("A")
        assert it.differs(request, "request opened") == []
