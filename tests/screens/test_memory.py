"""What was opened and closed leaves nothing behind."""

from __future__ import annotations

import gc
from weakref import WeakSet

import pytest
from textual._styles_cache import StylesCache

from tests.support.console import send
from tests.support.quiet import Quiet
from tests.support.states import STATES
from tests.support.stub import stub_app


@pytest.mark.night
async def test_of_dialogs_and_palettes_that_were_closed_no_line_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    caches: WeakSet[StylesCache] = WeakSet()  # One for each widget whose lines were drawn.
    create = StylesCache.__init__

    def create_and_count(cache: StylesCache) -> None:
        create(cache)
        caches.add(cache)

    monkeypatch.setattr(StylesCache, "__init__", create_and_count)
    app = stub_app(STATES["normal"])
    async with app.run_test(size=(120, 36)):
        quiet = Quiet(app)

        async def open_and_close() -> None:
            for key in ("ctrl+p", "A", "question_mark"):
                for pressed in (key, "escape"):
                    send(app, pressed)
                    await quiet.settle()
                    app.screen._compositor.render_strips()
            assert app.screen is app.main

        await open_and_close()
        gc.collect()
        before = len(caches)
        for _ in range(3):
            await open_and_close()
        gc.collect()
        assert 0 < len(caches) <= before + 2  # one more line may be drawn by now
