"""The screen as a picture, in every state and size. `--update-snapshots` accepts what is seen."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Iterable
from typing import Any

import pytest

from archo_tui.robot.clients import Requester, on_behalf_of
from archo_tui.robot.goals.queue import GoalQueue, QueuedGoal
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Hosted, Life, Snapshot
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.terminal.ascii import in_ascii
from archo_tui.station.alarms import AlarmBoard
from archo_tui.station.history import History
from tests.support.archo import SHELF
from tests.support.clock import TIME
from tests.support.console import send
from tests.support.night import corners
from tests.support.pictures import differs, steady
from tests.support.quiet import Quiet
from tests.support.states import ARRIVED, CANCELLED, NORMAL, STATES, ended, past
from tests.support.stub import StandingClock, StubRobot, stub_app

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


async def compare(
    request: pytest.FixtureRequest,
    name: str,
    snapshot: Snapshot,
    size: str,
    *keys: str,
    **options: Any,
) -> str:
    """One picture, as accepted."""
    svg = (await pictures(snapshot, [size], *keys, **options))[size]
    assert differs(request, f"{name} {size}", svg) == []
    return svg


async def rest(app: ArchoApp, quiet: Quiet) -> None:
    """Let the screen lay out and draw all that it has to."""
    await quiet.settle()
    app.tick()  # a new size may have more to say
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    robot.show_topic()
    await quiet.settle()


async def pictures(
    snapshot: Snapshot,
    sizes: Iterable[str],
    *keys: str,
    dialog: int = False,
    theme: str = "textual-dark",
    hosted: tuple[Hosted, ...] = (),
    seconds: int = 0,
    queue: Iterable[int] = (),
) -> dict[str, str]:
    """The screen after those keys, in each size; on-delays of alarms have passed.

    `seconds` were seen before; the shelves of the `queue` wait.
    """
    clock = StandingClock()
    clock.passed = -3.0
    first = SIZES[next(iter(sizes))]
    app = stub_app(snapshot, clock, hosted, size=first, in_field=not keys)
    if queue:  # none of them is sent while another one is on its way
        wanted = [QueuedGoal(SHELF, {"shelf_number": n}) for n in (1, *queue)]
        waits = GoalQueue().seen(snapshot, 0.0, 0).submit(wanted, Snapshot())
        assert waits.coming is not None
        coming = waits.coming._replace(before=99, is_handed_over=True)  # No snapshot shows it.
        app.station.goals.queue = waits._replace(coming=coming, todo=())
    for before in past(seconds):
        app.station.history.observe(*before)
    found = {}
    async with app.run_test(size=first) as pilot:
        quiet = Quiet(app)
        app.theme = theme
        clock.passed = 0.0
        app.tick()
        for number, size in enumerate(sizes):
            if number and dialog:  # opened again in each size
                app.pop_screen()
                await rest(app, quiet)
            if number:
                await pilot.resize_terminal(*SIZES[size])
            await rest(app, quiet)
            for key in keys if dialog or not number else ():
                send(app, key)
                await rest(app, quiet)
            assert len(app.screen_stack) == 1 + dialog
            found[size] = app.export_screenshot(simplify=True)
    return found


async def compare_all(
    request: pytest.FixtureRequest, name: str, snapshot: Snapshot, *keys: str, **options: Any
) -> None:
    """One app, resized through the sizes: by night through all of them."""
    sizes = ALL_SIZES if request.config.getoption("--night") else ALL_SIZES[:1]
    different = []
    for size, svg in (await pictures(snapshot, sizes, *keys, **options)).items():
        different += differs(request, f"{name} {size}", svg)
    assert different == [], "\n".join(different)


async def test_every_state_looks_as_accepted_in_every_size(request: pytest.FixtureRequest) -> None:
    clock = StandingClock()
    app = stub_app(STATES["nothing heard yet"], clock, size=SIZES["80x24"], in_field=True)
    robot: StubRobot = app.station.robot  # type: ignore[assignment]
    different = []
    async with app.run_test(size=SIZES["80x24"]) as pilot:
        quiet = Quiet(app)
        for size in ALL_SIZES if request.config.getoption("--night") else ALL_SIZES[::2]:
            await pilot.resize_terminal(*SIZES[size])
            for state, snapshot in STATES.items():
                # no state knows of the one before
                app.station._board, app.station.history = AlarmBoard(), History()
                for panel in (app.main.nodes, app.main.history, app.main.graph):
                    panel._inputs = None
                for clock.passed in (-3.0, 0.0):  # on-delays of alarms have passed
                    robot.put(snapshot)
                await rest(app, quiet)
                svg = app.export_screenshot(simplify=True)
                different += differs(request, f"{state} {size}", svg)
    assert different == [], "\n".join(different)


@pytest.mark.parametrize(
    ("name", "state", "keys", "dialog"),
    [
        ("help", "normal", ["f1"], True),
        ("help here", "normal", ["4", "question_mark"], True),
        ("edit", "normal", ["4", "home", "down", "down", "enter"], True),
        ("field", "normal", ["g", "1", "2"], False),
        ("question", "goal cancelling", ["q"], True),
        ("nodes hosted", "normal", ["5"], False),
        ("traceback", "normal", ["5", "home", "enter"], True),
        ("node", "normal", ["5", "home", "down", "down", "enter"], True),
        ("filter", "normal", ["4", "slash", *"speed"], False),
        ("filter finds nothing", "normal", ["4", "slash", *"warp", "enter"], False),
        ("search", "normal", ["6", "slash", *"shelf", "enter"], False),
        ("full screen", "normal", ["6", "e"], False),
        ("graph", "normal", ["8", "down"], False),
        ("resource", "normal", ["8", "end", "enter"], True),
        ("topic", "normal", ["8", "home", "down", "enter"], True),
        ("topic plotted", "normal", ["8", "home", "down", "enter", "p", "down", "down", "p"], True),
        (
            "topic opened",
            "normal",
            ["8", "home", "down", "enter", "end", "up", "enter", "end"],
            True,
        ),
        ("event", "normal", ["6", "home", "down", "enter"], True),
        ("save", "normal", ["4", "ctrl+s"], True),
    ],
)
async def test_what_keys_open_looks_as_accepted(
    request: pytest.FixtureRequest, name: str, state: str, keys: list[str], dialog: int
) -> None:
    plain = ("help", "edit", "field", "question", "node")  # their nodes run elsewhere
    hosted = () if name in plain else HOSTED
    await compare_all(request, name, STATES[state], *keys, dialog=dialog, hosted=hosted)


@pytest.mark.parametrize("state", ["normal", "motor stopped"])
async def test_a_large_terminal_looks_as_accepted(
    request: pytest.FixtureRequest, state: str
) -> None:
    await compare(request, state, STATES[state], "200x60", hosted=HOSTED, seconds=700)


@pytest.mark.parametrize("name", ["history", "history of a minute", "history of an hour"])
async def test_the_history_looks_as_accepted(request: pytest.FixtureRequest, name: str) -> None:
    ended = [ARRIVED._replace(time=TIME - 100), CANCELLED._replace(time=TIME - 400)]
    snapshot = STATES["battery low and moving"]._replace(history=tuple(ended))
    shorter, longer = "left_square_bracket", "right_square_bracket"
    span = {"history": [], "history of a minute": [shorter], "history of an hour": [longer]}[name]
    await compare_all(request, name, snapshot, "h", *span, seconds=700)


async def test_a_topic_stands_beside_the_graph_where_there_is_room(
    request: pytest.FixtureRequest,
) -> None:
    keys = ["8", "home", "down", "enter", "p"]
    await compare(request, "topic beside", STATES["normal"], "160x48", *keys, dialog=True)


async def test_the_history_stands_beside_the_panels_where_there_is_room(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = [ARRIVED._replace(time=TIME - 100), CANCELLED._replace(time=TIME - 400)]
    snapshot = STATES["battery low and moving"]._replace(history=tuple(ended))
    await compare(request, "history beside", snapshot, "160x48", seconds=700)
    monkeypatch.setenv("LC_ALL", "C")
    await compare(request, "history in ascii", snapshot, "160x48", seconds=700)


@pytest.mark.parametrize("size", corners(ALL_SIZES[:1], ALL_SIZES[1:]))
async def test_the_palette_looks_as_accepted(request: pytest.FixtureRequest, size: str) -> None:
    await compare(request, "palette", NORMAL, size, "ctrl+p", dialog=True, hosted=HOSTED)


@pytest.mark.parametrize("size", corners(ALL_SIZES[:1], ALL_SIZES[1:]))
async def test_the_alarms_look_as_accepted(request: pytest.FixtureRequest, size: str) -> None:
    snapshot = NORMAL._replace(battery=STATES["battery empty"].battery)
    await compare(request, "alarms", snapshot, size, "A", dialog=True, hosted=HOSTED)


@pytest.mark.parametrize("theme", ["textual-light", "high-contrast"])
async def test_the_other_themes_look_as_accepted(
    request: pytest.FixtureRequest, theme: str
) -> None:
    name = theme.removeprefix("textual-")
    await compare(request, name, STATES["battery low and moving"], "120x36", theme=theme)


async def test_without_utf_8_it_is_all_ascii(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LC_ALL", "C")
    svg = await compare(request, "ascii", STATES["battery low and moving"], "80x24")
    drawn = "".join(re.findall(r"<text[^>]*>([^<]*)</text>", svg)).replace("&#160;", " ")
    assert drawn.isascii(), set(drawn) - set(map(chr, range(128)))


def test_a_shortened_name_is_seen_to_be_one_in_ascii_too() -> None:
    assert in_ascii("start_type_de…ption") == "start_type_de~ption"


def test_no_unit_is_shown_as_a_question_mark_in_ascii() -> None:
    assert in_ascii("90°  0.4 m/s²  3 µs") == "90*  0.4 m/s2  3 us"


async def test_without_colour_every_word_stays(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    svg = await compare(request, "no colour", STATES["battery low and moving"], "80x24")
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
    sizes = "120x44", "160x48"
    for size in sizes if request.config.getoption("--night") else sizes[:1]:
        await compare(request, name, snapshot, size, *keys, queue=queue)


@pytest.mark.parametrize(
    ("name", "theme"),
    [("ascii", "textual-dark"), ("16 colours", "high-contrast"), ("light", "textual-light")],
)
async def test_a_large_screen_is_filled_as_accepted_elsewhere_too(
    request: pytest.FixtureRequest, name: str, theme: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "ascii":
        monkeypatch.setenv("LC_ALL", "C")
    snapshot, queue, keys = LARGE["large with a queue"]
    await compare(request, f"large {name}", snapshot, "120x44", *keys, queue=queue, theme=theme)


async def test_a_small_terminal_opens_at_the_top_with_the_percentage_in_the_header(
    request: pytest.FixtureRequest,
) -> None:
    svg = await compare(request, "small", STATES["battery low and moving"], "60x20")
    assert "18.0&#160;%&#160;MOVING&#160;to&#160;12" in svg
    assert "STOP&#160;" in svg


async def test_odd_sizes_break_nothing() -> None:
    app = stub_app(STATES["battery low and moving"])
    async with app.run_test(size=(40, 10)) as pilot:
        for size in ((20, 5), (79, 23), (300, 80)):
            await pilot.resize_terminal(*size)
            await Quiet(app).settle()
            assert app.is_running


async def test_equal_snapshots_draw_nothing() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)) as pilot:
        await pilot.pause()
        robot: StubRobot = app.station.robot  # type: ignore[assignment]
        lines = list(app.query("Line"))
        for line in lines:
            line.update = _must_not  # type: ignore[attr-defined]
        robot.put(NORMAL)
        await asyncio.sleep(0)
        assert len(lines) > 8


async def test_what_comes_while_the_screen_is_taken_down_is_harmless() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        remove = app._close_all

        async def close_all() -> None:
            await remove()
            app.tick()  # the clock or the robot, a moment too late

        app._close_all = close_all  # type: ignore[method-assign]


def _must_not(*_: object, **__: object) -> None:
    raise AssertionError("redrawn for nothing")


@pytest.mark.parametrize("size", corners(ALL_SIZES[:1], ALL_SIZES[1:]))
@pytest.mark.parametrize("name", ["request", "request opened"])
async def test_what_an_assistant_asks_looks_as_accepted(
    request: pytest.FixtureRequest, size: str, name: str
) -> None:
    app = stub_app(NORMAL, StandingClock(), size=SIZES[size])
    async with app.run_test(size=SIZES[size]):
        quiet = Quiet(app)
        requester = Requester("AI", "assistant 4711")
        goal = QueuedGoal(SHELF, {"shelf_number": 12})
        app.station._frontend = app.station.goals.frontend = app
        with on_behalf_of(requester):
            app.station.approvals.request(goal, "go to shelf 12")
        app.update_screen()
        await rest(app, quiet)
        if name == "request opened":
            send(app, "A")
            await rest(app, quiet)
        assert differs(request, f"{name} {size}", app.export_screenshot(simplify=True)) == []
