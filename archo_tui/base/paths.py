"""The folders of the console's files: `archo-tui/` in those that the system has for programs."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import platformdirs

from archo_tui.base.errors import ArchoError

_NAME = "archo-tui"


def make_folder(file: Path) -> None:
    """Make the folder of a file, readable by its owner only, and those above it if need be."""
    file.parent.parent.mkdir(parents=True, exist_ok=True)
    file.parent.mkdir(mode=0o700, exist_ok=True)


def config_file(name: str) -> Path:
    """Return the path of a file of the operator's choices, such as keymap or theme.

    Make nothing.
    """
    return _folder(platformdirs.user_config_path) / name


def state_file(name: str) -> Path:
    """Return the path of a file that the console writes, such as its journal; make nothing."""
    return _folder(platformdirs.user_state_path) / name


def journal_file() -> Path:
    """Return the path of the journal, the file of events that station/journal.py writes."""
    return state_file("journal.jsonl")


def typed_path(text: str) -> Path:
    """Return the path that a person has typed, with `~`; ArchoError if it names no file."""
    if not text.strip() or "\0" in text:
        raise ArchoError("type the name of a file")
    try:
        return Path(text).expanduser()
    except RuntimeError:
        raise ArchoError(f"no home folder is known for {text.partition('/')[0]}") from None


def _folder(find: Callable[..., Path]) -> Path:
    """Return the console's folder; without a home, a path below which no file can be made."""
    try:
        return find(_NAME, appauthor=False)
    except RuntimeError:
        return Path(os.devnull)
