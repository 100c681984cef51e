"""One workspace and one folder of share folders for all tests, which change neither."""

from __future__ import annotations

from pathlib import Path

import pytest

from archo_tui.user_code.ros_launch.workspace import Workspace
from tests.launch.planning import WORKSPACE, Launcher


@pytest.fixture(scope="session")
def workspace() -> Workspace:
    return Workspace.below(WORKSPACE)


@pytest.fixture(scope="session")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("prefix").resolve()


@pytest.fixture
def launcher(tmp_path: Path, workspace: Workspace, prefix: Path) -> Launcher:
    return Launcher(tmp_path, workspace, prefix)
