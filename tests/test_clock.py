"""The time of day is the operator's own, wherever that is."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from archo_tui.clock import time_of_day


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
