"""Everything that is written on the screen can be read, in every theme that we promise it for."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from rich.style import Style
from textual.color import Color
from textual.strip import Strip
from textual.theme import BUILTIN_THEMES

from archo_tui.screen.app import ArchoApp
from archo_tui.screen.terminal.themes import HIGH_CONTRAST, contrast, derive_tones
from tests.support.console import send
from tests.support.night import corners
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StandingClock, stub_app

TEXT, OFF = 4.5, 3.0  # as WCAG asks for text, and for what cannot be used
THEMES = ("textual-dark", "textual-light", "high-contrast")


def colours(style: Style) -> tuple[Color, Color]:
    """What a style writes with, and on."""
    assert style.color is not None
    assert style.bgcolor is not None
    front, back = Color.from_rich_color(style.color), Color.from_rich_color(style.bgcolor)
    if style.dim:
        front = back.blend(front, 0.5)
    return (back, front) if style.reverse else (front, back)


def unreadable(app: ArchoApp, strips: Iterable[Strip]) -> list[tuple[str, float]]:
    """The texts of too little contrast, and how much they have."""
    off, found = Color.parse(app.theme_variables["off"]), []
    for segment in (segment for strip in strips for segment in strip):
        if segment.style is not None and any(letter.isalnum() for letter in segment.text):
            front, back = colours(segment.style)
            ratio = contrast(front, back)
            if ratio < (OFF if front == off else TEXT):
                found.append((segment.text, ratio))
    return found


@pytest.mark.parametrize("name", THEMES)
def test_every_tone_can_be_read_on_every_background(name: str) -> None:
    theme = BUILTIN_THEMES.get(name, HIGH_CONTRAST)
    variables = {**theme.to_color_system().generate(), **(theme.variables or {})}
    tones = derive_tones(variables)
    for tone, least in (("quiet", TEXT), ("off", OFF), ("warn", TEXT), ("bad", TEXT)):
        for behind in ("background", "surface", "panel"):
            ratio = contrast(Color.parse(tones[tone]), Color.parse(variables[behind]))
            assert ratio >= least, (tone, behind)


@pytest.mark.parametrize("theme", corners(["textual-light"], ["textual-dark", "high-contrast"]))
async def test_every_text_can_be_read(theme: str) -> None:
    app = stub_app(STATES["normal"], StandingClock())
    async with app.run_test(size=(120, 36)):
        app.theme, quiet = theme, Quiet(app)
        for name, snapshot in STATES.items():
            app._on_snapshot(snapshot)
            app.tick()
            await quiet.settle()
            assert unreadable(app, app.screen._compositor.render_strips()) == [], name


@pytest.mark.parametrize(
    ("state", "keys"),
    [("normal", ["enter", "question_mark"]), ("battery low and moving", ["A", "r"])],
)
async def test_every_text_of_a_dialog_can_be_read_in_every_theme(
    state: str, keys: list[str]
) -> None:
    app = stub_app(STATES[state], StandingClock())
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        for key in keys:
            send(app, key)
            for app.theme in THEMES:
                await quiet.settle()
                assert app.screen is not app.main
                box = app.screen.children[0].region
                drawn = app.screen._compositor.render_strips()[box.y : box.bottom]
                inside = [strip.crop(box.x, box.right) for strip in drawn]
                assert unreadable(app, inside) == [], app.theme
            send(app, "escape")
            await quiet.settle()
