"""The console in a terminal."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.terminal import Start, Terminal


@pytest.fixture
def start(terminals: list[Terminal]) -> Start:
    """Start the console, and wait until it shows that text; it is closed at the end."""

    def started(*words: str, shows: str = "max_speed", **options: Any) -> Terminal:
        terminals.append(Terminal(*words, **options))
        if shows:
            terminals[-1].until(shows)
        return terminals[-1]

    return started
