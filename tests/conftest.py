"""Chooses the engine for the whole run, before any test module imports rclpy."""

from __future__ import annotations

import gc
import itertools
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import lru_cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from textual.screen import Screen

from archo_tui.robot_file import load
from archo_tui.ros import engine
from tests.support import chosen, forks, textual_once

if TYPE_CHECKING:
    from tests.support.ros import Ros
    from tests.support.terminal import Terminal

ROOT = Path(__file__).parent.parent


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--engine",
        choices=("embedded", "ros2"),
        default="embedded",
        help="what `import rclpy` means in the tests",
    )
    parser.addoption(
        "--end-to-end", action="store_true", help="run the tests that need tmux and sshd as well"
    )
    parser.addoption(
        "--night", action="store_true", help="run the tests that are marked `night` as well"
    )
    parser.addoption(
        "--update-snapshots", action="store_true", help="accept the screens as they look now"
    )


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Let forks do on Linux what the workers of xdist do elsewhere."""
    count = config.getoption("numprocesses")
    if sys.platform == "linux" and isinstance(count, int) and not config.getoption("usepdb"):
        config.option.numprocesses = 0
        if count:
            config.pluginmanager.register(forks.Forks(count))


@pytest.fixture
def unlimited(tmp_path: Path) -> Path:
    """ARCHO's robot file without the highest shelf: beyond it the robot itself refuses."""
    file = tmp_path / "unlimited.yaml"
    text = load.default_path().read_text(encoding="utf-8")
    file.write_text(re.sub(r" +high: \{.*\n", "", text), encoding="utf-8")
    return file


# these import what Windows lacks, and are all of POSIX
_POSIX = {
    *("test_terminal", "test_journal", "test_own_interfaces", "test_cli"),
    *("test_plain", "test_plain_input", "test_plain_stops"),
    *("test_files", "test_two_processes"),
    *("test_stop_is_final", "test_walk_with_stops"),
    *("test_shell", "test_hostile", "test_beside_a_screen", "test_pages", "test_python"),
    *("test_completions", "test_stories", "test_own_files", "test_docs"),
    *("test_tools", "test_which_console", "test_stop_rounds", "test_in_the_console"),
}


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    if collection_path.stem in _POSIX and sys.platform == "win32":
        return True
    wanted = config.getoption("--end-to-end")
    return True if collection_path.name == "end_to_end" and not wanted else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.stem in _POSIX:
            item.add_marker(pytest.mark.posix)
    if not config.getoption("--night"):
        is_embedded = config.getoption("--engine") == "embedded"
        marks = {"night"} if is_embedded else {"night", "waits", "pure"}
        left = [item for item in items if any(map(item.get_closest_marker, marks))]
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in set(left)]


def pytest_collection_finish() -> None:
    gc.collect()
    gc.freeze()  # modules stay: no later collection looks through them


def pytest_sessionfinish() -> None:
    gc.collect()  # what was never closed is said now
    gc.freeze()  # pytest collects five times more


def pytest_configure(config: pytest.Config) -> None:
    _set_terminal()
    _share_bytecode(config)
    os.environ["TZ"] = "UTC"  # times of day are part of pictures, and some texts are kept
    if sys.platform != "win32":
        time.tzset()
    gc.set_threshold(500_000)  # an app makes many objects, and most tests make an app
    chosen.ENGINE = config.getoption("--engine")
    if config.getoption("--engine") == "embedded":
        os.environ["AMENT_PREFIX_PATH"] = str(Path(__file__).parent)  # share/depot_interfaces
        engine.activate("embedded")
        if sys.platform == "linux":
            from tests.support import warm

            warm.allow()
    else:  # real ROS 2: nothing may leave this process
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
        os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"  # while tests are collected: _own_folders
        # Programs are processes of their own, which run the console of this folder.
        os.environ["PYTHONPATH"] = f"{ROOT}{os.pathsep}{ROOT / 'nodes'}"
        engine.activate("ros2")
        config.addinivalue_line("filterwarnings", "default::DeprecationWarning")  # ROS's own
        # A goal whose executor ends before it begins.
        unbegun = "ignore:coroutine 'ActionServer._execute_goal' was never awaited:RuntimeWarning"
        config.addinivalue_line("filterwarnings", unbegun)
    # the textbook's listings say `warn`, of which rclpy warns
    config.addinivalue_line("filterwarnings", "ignore:Deprecated in favor:DeprecationWarning")


def _share_bytecode(config: pytest.Config) -> None:
    """Where no bytecode is to be written beside sources, let programs share it in a folder.

    Each program that a test starts would compile all modules of the console for itself.
    """
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
        folder = tempfile.mkdtemp()
        config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        os.environ["PYTHONPYCACHEPREFIX"] = folder


def _set_terminal() -> None:
    """Make the terminal the same for all, whoever runs the tests."""
    unset = {"COLUMNS", "LINES", "NO_COLOR", "COLORTERM", "LANG", "LC_CTYPE", "SSH_CLIENT"}
    for name in list(os.environ):
        if name in unset or name == "XDG_RUNTIME_DIR" or name.startswith("TEXTUAL"):
            del os.environ[name]
    os.environ |= {"LC_ALL": "C.UTF-8", "TERM": "xterm-256color"}


_numbers = itertools.count()


@pytest.fixture
def tmp_path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of the test's own; pytest's fixture asks the disk five times as often for it."""
    name = re.sub(r"\W", "_", request.node.name)[:30]
    folder = tmp_path_factory.getbasetemp() / f"{next(_numbers)}_{name}"
    folder.mkdir(mode=0o700)
    return folder


@pytest.fixture
def _freed() -> Iterator[None]:
    """No app outlives its test; torn down after `monkeypatch`, which may have patched widgets."""
    yield
    textual_once.free_all()


@pytest.fixture(autouse=True)
def _own_folders(
    request: pytest.FixtureRequest, _freed: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[None]:
    """What the console remembers stays in the test.

    rosidl checks fields where the engines are compared, and nowhere else: the console runs as its
    users run it, without the variable. Each module of a message has read it once and for all when
    it was imported; what the parameters of tests hold is made before.
    """
    monkeypatch.setenv("XDG_CONFIG_HOME", f"{tmp_path}/config")
    monkeypatch.setenv("XDG_STATE_HOME", f"{tmp_path}/state")
    # no test may reach a console that runs beside it
    sockets = tempfile.mkdtemp(prefix="at", dir="/tmp")  # a socket's path has 107 bytes at most
    monkeypatch.setenv("ARCHO_TUI_SOCKETS", f"{sockets}/s")
    checks = "1" if "contract" in request.path.parts else ""
    monkeypatch.setenv("ROS_PYTHON_CHECK_FIELDS", checks)
    for module in list(sys.modules.values()) if chosen.ENGINE == "ros2" else ():
        if "ros_python_check_fields" in vars(module):
            vars(module)["ros_python_check_fields"] = checks
    yield
    shutil.rmtree(sockets, ignore_errors=True)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder that the test is in: its files have short names, which are never wrapped."""
    monkeypatch.chdir(tmp_path)
    return Path()


@pytest.fixture(autouse=True)
def _time(request: pytest.FixtureRequest) -> Iterator[None]:
    """A clock that the test moves, on the embedded engine; real time where the test says so."""
    from tests.support import clock

    if chosen.ENGINE != "embedded" or request.node.get_closest_marker("real_time"):
        yield
        return
    from rclpy import _time_source

    clock.current = clock.VirtualClock()
    before = _time_source.use(clock.current)
    yield
    _time_source.use(before)
    clock.current = None


@pytest.fixture(autouse=True, scope="session")
def _as_all_tests_want_it() -> None:
    """Change what all tests want otherwise, once for the whole run."""
    from archo_tui.screen.main import MainScreen

    # Style sheets and ARCHO's file are parsed once for all the apps.
    textual_once.share()
    load.parse = lru_cache(load.parse)
    # Screens are laid out, but nothing is drawn to a terminal that nobody sees.
    Screen._compositor_refresh = draw_nothing  # type: ignore[assignment, method-assign]
    # The first picture is filled at once: `Console.ready` waits for the robot's nodes.
    on_mount = MainScreen.on_mount

    @wraps(on_mount)
    def on_mount_and_fill(screen: MainScreen) -> None:
        on_mount(screen)
        screen.call_later(screen._fill)

    MainScreen.on_mount = on_mount_and_fill  # type: ignore[assignment, method-assign]


def draw_nothing(screen: Screen[Any]) -> None:
    """In place of what draws a screen; `support/console.py` reads it when it is new only."""
    screen._dirty_widgets.clear()
    screen._compositor._dirty_regions.clear()
    vars(screen)["draws"] = vars(screen).get("draws", 0) + 1


@pytest.fixture
def terminals() -> Iterator[list[Terminal]]:
    """Terminals that are closed at the end."""
    made: list[Terminal] = []
    yield made
    for terminal in made:
        terminal.close()


@pytest.fixture
def start(terminals: list[Terminal]) -> Callable[..., Terminal]:
    """Start the console, and wait until it shows that text; it is closed at the end."""

    from tests.support import terminal  # needs POSIX

    def started(*words: str, shows: str = "max_speed", **options: Any) -> Terminal:
        terminals.append(terminal.Terminal(*words, **options))
        if shows:
            terminals[-1].until(shows)
        return terminals[-1]

    return started


@pytest.fixture
def ros() -> Iterator[Ros]:
    """A ROS graph of the test's own; callbacks must not have raised unless the test says so."""
    from tests.support.ros import Ros  # not before the engine is chosen

    graph = Ros()
    yield graph
    graph.close()
    assert graph.errors == []
