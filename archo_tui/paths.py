"""Where the console keeps its files: `archo-tui/` in the folders that the system has for that."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import platformdirs

_NAME = "archo-tui"


def make_folder(file: Path) -> None:
    """Make the folder of one of these files, for nobody else to look into. Raises OSError."""
    file.parent.parent.mkdir(parents=True, exist_ok=True)
    file.parent.mkdir(mode=0o700, exist_ok=True)


def config_file(name: str) -> Path:
    """What the operator chose: keymap, theme. On Linux below XDG_CONFIG_HOME or `~/.config`."""
    return _folder(platformdirs.user_config_path) / name


def state_file(name: str) -> Path:
    """What the console wrote: journal, logs. Below XDG_STATE_HOME or `~/.local/state`."""
    return _folder(platformdirs.user_state_path) / name


def journal_file() -> Path:
    """The operator's log: archo_tui/journal.py."""
    return state_file("journal.jsonl")


def _folder(find: Callable[..., Path]) -> Path:
    """The folder; where the user has no home, one in which nothing can be."""
    try:
        return find(_NAME, appauthor=False)
    except RuntimeError:
        return Path(os.devnull)
