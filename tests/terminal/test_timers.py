"""The app's timers on a machine that is busy while they begin to wait."""

from __future__ import annotations

from itertools import count

import pytest

from tests.support.quiet import Quiet
from tests.support.states import NORMAL
from tests.support.stub import stub_app


async def test_a_size_that_comes_while_the_machine_is_busy_is_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    app = stub_app(NORMAL)
    async with app.run_test(size=(120, 36)) as pilot:
        seconds = count()  # Between two looks at the time a second passes.
        monkeypatch.setattr("textual._time.get_time", lambda: float(next(seconds)))
        await pilot.resize_terminal(80, 24)
        await Quiet(app).until(lambda: app.screen._compositor.size == (80, 24), str)
