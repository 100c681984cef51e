"""Where the console keeps its files: `archo-tui/` in the XDG folders."""

from __future__ import annotations

import os
from pathlib import Path

# XDG Base Directory Specification: the variable, or this below the home folder
_FOLDERS = {"XDG_CONFIG_HOME": ".config", "XDG_STATE_HOME": ".local/state"}


def config_file(name: str) -> Path:
    """What the operator chose: keymap, settings."""
    return _folder("XDG_CONFIG_HOME") / name


def state_file(name: str) -> Path:
    """What the console wrote down: journal, logs."""
    return _folder("XDG_STATE_HOME") / name


def _folder(variable: str) -> Path:
    return Path(os.environ.get(variable) or Path.home() / _FOLDERS[variable]) / "archo-tui"
