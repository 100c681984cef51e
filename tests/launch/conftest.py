"""One workspace for all tests, which do not change it."""

from __future__ import annotations

import pytest

from archo_tui.launch.workspace import Workspace
from tests.launch.planning import WORKSPACE


@pytest.fixture(scope="session")
def workspace() -> Workspace:
    return Workspace.below(WORKSPACE)
