"""The names that Textual does not promise and that the console needs: each is still there.

Textual is pinned to its minor version because of them. A new use of a private name belongs here.
"""

from __future__ import annotations

import inspect
from functools import cache
from pathlib import Path

import pytest
from textual import _ansi_sequences, _keyboard_protocol, keys
from textual._compositor import Compositor
from textual._xterm_parser import XTermParser
from textual.app import App
from textual.binding import BindingsMap
from textual.command import CommandList, CommandPalette
from textual.drivers.linux_driver import LinuxDriver
from textual.keys import Keys
from textual.message import Message
from textual.screen import Screen
from textual.widget import Widget

# where it is used: its owner and name
METHODS = [
    ("terminal/app.py", App, "_handle_exception"),
    ("terminal/app.py", App, "_close_messages_no_wait"),
    ("terminal/driver.py", LinuxDriver, "_sigcont_application"),
    ("terminal/driver.py", LinuxDriver, "start_application_mode"),
    ("terminal/driver.py", LinuxDriver, "stop_application_mode"),
    ("terminal/driver.py", LinuxDriver, "resume_application_mode"),
    ("terminal/driver.py", LinuxDriver, "run_input_thread"),
    ("terminal/driver.py", LinuxDriver, "process_message"),
    ("terminal/keyboard.py", XTermParser, "feed"),
    ("terminal/keys.py", keys, "_character_to_key"),
    ("widgets/rows.py", Widget, "_refresh_scrollbars"),
    ("screens/main.py", Screen, "_compositor_refresh"),
    ("screens/base.py", Screen, "_on_resize"),
    ("screens/palette.py", CommandPalette, "_on_click"),
    ("screens/palette.py", CommandPalette, "_cancel_gather_commands"),
    ("screens/palette.py", CommandPalette, "_stop_no_matches_countdown"),
    ("screens/palette.py", CommandPalette, "_dispatch_message"),
    ("screens/palette.py", CommandPalette, "_watch__show_busy"),
    ("screens/palette.py", CommandList, "_move_page"),
    ("screens/palette.py", CommandList, "_on_click"),
    ("terminal/compositor.py", Compositor, "_get_renders"),
    ("terminal/compositor.py", Compositor, "_regions_to_spans"),
    ("terminal/compositor.py", Compositor, "render_partial_update"),
    ("commands/keymap.py", keys, "_character_to_key"),
    ("tests/support/console.py", keys, "_get_unicode_name_from_key"),
    ("tests/support/quiet.py", Screen, "_on_timer_update"),
    ("tests/conftest.py", Screen, "_compositor_refresh"),
]
# set in a constructor or function: the source says so
ATTRIBUTES = [
    ("terminal/app.py", App, "_exit"),
    ("terminal/typed.py", Message, "_prevent"),
    ("terminal/app.py", App, "_driver"),
    ("terminal/app.py", App, "_return_code"),
    ("app.py", BindingsMap, "key_to_bindings"),
    ("terminal/driver.py", LinuxDriver, "_writer_thread"),
    ("terminal/driver.py", LinuxDriver, "_auto_restart"),
    ("terminal/driver.py", LinuxDriver, "exit_event"),
    ("terminal/driver.py", LinuxDriver, "fileno"),
    ("tests/support/quiet.py", Screen, "_layout_required"),
    ("tests/support/quiet.py", Screen, "_scroll_required"),
    ("tests/support/quiet.py", Screen, "_repaint_required"),
    ("tests/support/quiet.py", Screen, "_dirty_widgets"),
    ("tests/support/quiet.py", Screen, "_callbacks"),
    ("screens/main.py", Screen, "_compositor"),
    ("terminal/compositor.py", Compositor, "_cuts"),
    ("terminal/compositor.py", Compositor, "_dirty_regions"),
    ("terminal/compositor.py", Compositor, "_full_map_invalidated"),
    ("tests/support/console.py", Screen, "_compositor"),
]


@cache
def source_of(owner: type) -> str:
    """Of a class and what it inherits from Textual."""
    files = {inspect.getsourcefile(b) for b in owner.__mro__ if b.__module__.startswith("textual")}
    return "".join(Path(file).read_text(encoding="utf-8") for file in files if file)


@pytest.mark.parametrize(("used_by", "owner", "name"), METHODS)
def test_a_private_method_is_there(used_by: str, owner: object, name: str) -> None:
    assert callable(getattr(owner, name, None)), f"{used_by} needs {owner}.{name}"


@pytest.mark.parametrize(("used_by", "owner", "name"), ATTRIBUTES)
def test_a_private_attribute_is_there(used_by: str, owner: type, name: str) -> None:
    assert f"self.{name}" in source_of(owner), f"{used_by} needs {owner.__name__}.{name}"


def test_the_tables_of_what_terminals_send_are_there() -> None:
    table = _ansi_sequences.ANSI_SEQUENCES_KEYS  # commands/keymap.py, terminal/keys.py and others
    assert table["\x18"] == (Keys.ControlX,)
    assert table["\x1bOp"] == "0"
    assert _keyboard_protocol.FUNCTIONAL_KEYS["27u"] == "escape"  # terminal/keys.py
    assert "left_shift" in _keyboard_protocol.MODIFIER_FUNCTIONAL_KEYS
