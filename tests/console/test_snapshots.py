"""The screen as a picture, in every state and size. `--update-snapshots` accepts what is seen."""

from __future__ import annotations

import asyncio
import re
import time
from pathlib import Path

import pytest

from archo_tui.robot.state import Hosted, Life, Snapshot
from tests.console.states import NORMAL, STATES
from tests.support.stub import StandingClock, StubRobot, stub_app
from tests.support.waiting import DEADLINE

FOLDER = Path(__file__).parent.parent / "snapshots"
SIZES = {"80x24": (80, 24), "120x36": (120, 36), "160x48": (160, 48)}


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
    Hosted("/motor_controller", Life.STUCK, serves=True),
)


@pytest.fixture(autouse=True)
def _utc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "UTC")
    monkeypatch.setenv("LC_ALL", "C.UTF-8")
    monkeypatch.chdir("/")  # a dialog names the folder
    time.tzset()


def normalised(svg: str) -> str:
    """Without the ids that Rich makes anew each time."""
    return re.sub(r"terminal-\d+", "terminal", svg)


def compare(request: pytest.FixtureRequest, name: str, actual: str) -> None:
    """Fail when the picture differs from the accepted one; the new one is left beside it."""
    path = FOLDER / f"{name.replace(' ', '_')}.svg"
    new = path.with_suffix(".new.svg")
    if request.config.getoption("--update-snapshots"):
        path.write_text(actual)
    if path.is_file() and path.read_text() == actual:
        new.unlink(missing_ok=True)
        return
    new.write_text(actual)
    pytest.fail(f"{path.name} differs: look at {new}, accept it with --update-snapshots")


async def picture(
    snapshot: Snapshot,
    size: tuple[int, int],
    *keys: str,
    dialog: bool = False,
    theme: str = "textual-dark",
    hosted: tuple[Hosted, ...] = (),
) -> str:
    """The screen after those keys, when it has come to rest; on-delays of alarms have passed."""
    clock = StandingClock()
    clock.passed = -3.0
    app = stub_app(snapshot, clock, hosted)
    async with app.run_test(size=size) as pilot:
        app.theme = theme
        clock.passed = 0.0
        app.tick()
        await pilot.press(*keys)
        end = time.monotonic() + DEADLINE
        last: list[str] = []
        while True:
            await pilot.pause(0.02)
            app.tick()
            lines = [strip.text for strip in app.screen._compositor.render_strips()]
            if lines == last and (len(app.screen_stack) == 2 or not dialog):
                return normalised(app.export_screenshot(simplify=True))
            last = lines
            assert time.monotonic() < end, "the screen does not come to rest"


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("state", STATES)
async def test_every_state_looks_as_accepted(
    request: pytest.FixtureRequest, state: str, size: str
) -> None:
    compare(request, f"{state} {size}", await picture(STATES[state], SIZES[size]))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("name", "keys"), [("help", ["question_mark"]), ("edit", ["down", "down", "enter"])]
)
async def test_every_dialog_looks_as_accepted(
    request: pytest.FixtureRequest, name: str, keys: list[str], size: str
) -> None:
    svg = await picture(NORMAL, SIZES[size], *keys, dialog=True)
    compare(request, f"{name} {size}", svg)


@pytest.mark.parametrize("size", SIZES)
async def test_the_field_looks_as_accepted(request: pytest.FixtureRequest, size: str) -> None:
    compare(request, f"field {size}", await picture(NORMAL, SIZES[size], "g", "1", "2"))


@pytest.mark.parametrize("size", SIZES)
async def test_the_question_looks_as_accepted(request: pytest.FixtureRequest, size: str) -> None:
    svg = await picture(STATES["goal cancelling"], SIZES[size], "q", dialog=True)
    compare(request, f"question {size}", svg)


@pytest.mark.parametrize("size", SIZES)
async def test_nodes_of_this_process_look_as_accepted(
    request: pytest.FixtureRequest, size: str
) -> None:
    svg = await picture(NORMAL, SIZES[size], "5", hosted=HOSTED)
    compare(request, f"nodes hosted {size}", svg)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(
    ("name", "keys", "dialog"),
    [
        ("traceback", ["5", "home", "enter"], True),
        ("filter", ["4", "slash", *"speed"], False),
        ("filter finds nothing", ["4", "slash", *"warp", "enter"], False),
        ("search", ["6", "slash", *"shelf", "enter"], False),
        ("full screen", ["6", "e"], False),
        ("event", ["6", "down", "enter"], True),
        ("save", ["4", "ctrl+s"], True),
        ("palette", ["ctrl+p"], True),
    ],
)
async def test_what_keys_open_looks_as_accepted(
    request: pytest.FixtureRequest, name: str, keys: list[str], dialog: bool, size: str
) -> None:
    svg = await picture(NORMAL, SIZES[size], *keys, dialog=dialog, hosted=HOSTED)
    compare(request, f"{name} {size}", svg)


@pytest.mark.parametrize("theme", ["textual-light", "high-contrast"])
async def test_the_other_themes_look_as_accepted(
    request: pytest.FixtureRequest, theme: str
) -> None:
    svg = await picture(STATES["battery low and moving"], SIZES["120x36"], theme=theme)
    compare(request, f"{theme.removeprefix('textual-')} 120x36", svg)


async def test_without_utf_8_it_is_all_ascii(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LC_ALL", "C")
    svg = await picture(STATES["battery low and moving"], SIZES["80x24"])
    drawn = "".join(re.findall(r"<text[^>]*>([^<]*)</text>", svg)).replace("&#160;", " ")
    assert drawn.isascii(), set(drawn) - set(map(chr, range(128)))
    compare(request, "ascii 80x24", svg)


async def test_without_colour_every_word_stays(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    svg = await picture(STATES["battery low and moving"], SIZES["80x24"])
    colours = {tuple(c[i : i + 2] for i in (1, 3, 5)) for c in re.findall(r"#[0-9a-f]{6}", svg)}
    grey = {colour for colour in colours if len(set(colour)) == 1}
    assert len(colours - grey) <= 4, colours - grey  # the drawn window's own frame and buttons
    compare(request, "no colour 80x24", svg)


@pytest.mark.parametrize("panel", "123456")
async def test_a_tiny_terminal_shows_the_focused_panel_between_header_and_footer(
    request: pytest.FixtureRequest, panel: str
) -> None:
    svg = await picture(STATES["battery low and moving"], (40, 10), panel)
    compare(request, f"tiny panel {panel}", svg)


@pytest.mark.parametrize("size", [(40, 10), (20, 5), (79, 23), (300, 80)])
async def test_odd_sizes_break_nothing(size: tuple[int, int]) -> None:
    app = stub_app(STATES["battery low and moving"])
    async with app.run_test(size=size) as pilot:
        await pilot.pause()
        assert app.is_running


async def test_equal_snapshots_draw_nothing() -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)) as pilot:
        await pilot.pause()
        robot: StubRobot = app.robot  # type: ignore[assignment]
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
