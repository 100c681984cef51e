"""The button that enter presses is filled, and a dialog has no more than one empty row."""

from __future__ import annotations

from textual.color import Color

from archo_tui.screen.app import ArchoApp
from archo_tui.screen.widgets.field import Button
from tests.support.console import screen_text, send
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import StandingClock, stub_app

EDIT = ("4", "home", "down", "down", "enter")


def filled(app: ArchoApp) -> list[str]:
    """The ids of the buttons that are filled with the accent's colour."""
    accent = Color.parse(app.theme_variables["primary-darken-2"])
    return [
        str(button.id)
        for button in app.screen.query(Button)
        if button.styles.background.rgb == accent.rgb
    ]


async def test_the_button_that_enter_presses_is_filled() -> None:
    app = stub_app(STATES["normal"], StandingClock())
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        send(app, *EDIT)
        await quiet.settle()
        assert filled(app) == ["submit"]
        send(app, "tab")  # Enter now presses the button that has the focus.
        await quiet.settle()
        assert filled(app) == ["leave"]
        send(app, "shift+tab")
        await quiet.settle()
        assert filled(app) == ["submit"]


async def test_a_dialog_has_one_empty_row_and_a_question_its_safe_answer_filled() -> None:
    app = stub_app(STATES["motor moving"], StandingClock())
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)
        await quiet.settle()
        for keys in (EDIT, ("4", "ctrl+s"), ("q",)):
            send(app, *keys)
            await quiet.settle()
            box = app.screen.children[0].region
            rows = screen_text(app).splitlines()[box.y + 1 : box.bottom - 1]
            inside = [row[box.x + 1 : box.right - 1].strip() for row in rows]
            assert inside.count("") <= 1, inside
            if keys == ("q",):
                assert filled(app) == ["answer-0"]
            send(app, "escape")
            await quiet.settle()
