"""What was opened and closed leaves nothing behind."""

from __future__ import annotations

import gc

from textual._styles_cache import StylesCache

from tests.support.console import send
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import stub_app


def kept() -> int:
    """How many widgets' drawn lines there are."""
    gc.collect()
    return sum(isinstance(it, StylesCache) for it in gc.get_objects())


async def test_of_dialogs_and_palettes_that_were_closed_no_line_is_kept() -> None:
    app = stub_app(STATES["normal"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)

        async def open_and_close() -> int:
            for key in ("ctrl+p", "A", "question_mark"):
                for pressed in (key, "escape"):
                    send(app, pressed)
                    await quiet.settle()
                    app.screen._compositor.render_strips()
            assert app.screen is app.main
            return kept()

        before = await open_and_close()
        for _ in range(3):
            await open_and_close()
        assert kept() <= before + 2  # one more line may be drawn by now
