"""What was typed into the forms before, a few dozen at most, and that a goal was sent.

Kept over restarts.
"""

from __future__ import annotations

import contextlib
import json
import os
import threading
from typing import Any

from archo_tui.paths import make_folder, state_file
from archo_tui.regular_files import read, replace

MOST = 50
_SENT = "goal_sent"  # an empty file

_writing = threading.Lock()  # two goals may be sent at once


def load(form: str) -> list[list[str]]:
    """The texts of each time, the oldest first; nothing when there are none or they are broken."""
    return _texts(_read(), form)


def add(form: str, typed: list[str]) -> None:
    """Keep it as the last; a disk that is full or read-only keeps nothing."""
    path = state_file("typed.json")
    with _writing, contextlib.suppress(OSError):
        known = _read()
        others = [texts for texts in _texts(known, form) if texts != typed]
        make_folder(path)
        replace(path, json.dumps({**known, form: [*others, typed][-MOST:]}))


def has_sent() -> bool:
    """True when this user has sent a goal, whenever that was."""
    return os.path.exists(state_file(_SENT))  # False also where nobody may look


def keep_sent() -> None:
    """From now on; a disk that is full or read-only keeps nothing."""
    path = state_file(_SENT)
    with contextlib.suppress(OSError):
        make_folder(path)
        path.touch(mode=0o600)


def _read() -> dict[str, Any]:
    """What is kept of every form."""
    with contextlib.suppress(OSError, ValueError, RecursionError):
        known = json.loads(read(state_file("typed.json")))
        return known if isinstance(known, dict) else {}
    return {}


def _texts(known: dict[str, Any], form: str) -> list[list[str]]:
    found = known.get(form)
    if not isinstance(found, list):
        return []
    return [list(map(str, texts)) for texts in found if isinstance(texts, list)][-MOST:]
