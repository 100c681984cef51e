"""A button that is narrower than its padding, as for a moment while a terminal is resized."""

from __future__ import annotations

from textual.app import App, ComposeResult

from archo_tui.screen.widgets.field import Button


class _Narrow(App[None]):
    CSS = "Button { min-width: 0; width: 2; }"

    def compose(self) -> ComposeResult:
        yield Button("Release", lambda: None, id="release")


async def test_a_button_without_a_cell_for_its_label_is_drawn() -> None:
    app = _Narrow()
    async with app.run_test(size=(20, 5)) as pilot:
        for width in (2, 1, 0, 3):
            app.query_one(Button).styles.width = width
            await pilot.pause()
            assert app.is_running
            app.query_one(Button).styles.width = 12
            await pilot.pause()
            assert "Release" in app.screen._compositor.render_strips()[0].text
