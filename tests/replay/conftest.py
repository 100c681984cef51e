"""A recording for all tests of this folder."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

_driven: list[Path] = []


@pytest.fixture
async def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """To a shelf in 1.5 s, and a STOP: recorded once for all tests."""
    if not _driven:
        made = await _drive()
        _driven.append(tmp_path_factory.mktemp("drive") / made.name)
        shutil.copytree(made, _driven[0])
    return _driven[0]


async def _drive() -> Path:
    # Only once the engine is chosen.
    from tests.replay.recorded import written
    from tests.support import clock
    from tests.support.console import BRISK, console

    async with console(*BRISK) as op:
        await op.press("g", *"12", "enter")
        await op.until("✓ ARRIVED")
        await op.at(clock.seconds() + 1.0)
        await op.press("ctrl+x")
        await op.until("STOPPED: look for the cause")
        return await written(op)
