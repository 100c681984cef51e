"""The time of day is the operator's own, wherever that is."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from archo_tui.base.clock import time_of_day
from tests.support import clock
from tests.support.console import FAST, console


@pytest.fixture
def nepal(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    with monkeypatch.context() as patch:
        patch.setenv("TZ", "Asia/Kathmandu")
        time.tzset()
        yield
    time.tzset()


@pytest.mark.usefixtures("nepal")
def test_the_time_of_day_is_local() -> None:
    assert time_of_day(1_700_000_000) == "03:58:20"


def test_and_elsewhere_it_is_another() -> None:
    assert time_of_day(1_700_000_000) == "22:13:20"


async def test_past_2038_the_robot_drives_and_that_is_said_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(clock, "TIME", 2.0**31 + 100)  # messages carry seconds in an int32
    async with console(*FAST) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("Arrived at shelf 12")
        events = [event.text for event in op.app.view.snapshot.events]
    assert len([text for text in events if "past January 2038" in text]) == 1
