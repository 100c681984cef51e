"""What was typed into the forms before: kept over restarts, a few dozen at most."""

from __future__ import annotations

import contextlib
import json
import os
import threading

from archo_tui.paths import make_folder, state_file

MOST = 50

_writing = threading.Lock()  # two goals may be sent at once


def load(form: str) -> list[list[str]]:
    """The texts of each time, the oldest first; nothing when there are none or they are broken."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        found = json.loads(state_file("typed.json").read_text(encoding="utf-8")).get(form, [])
        return [list(map(str, texts)) for texts in found if isinstance(texts, list)][-MOST:]
    return []


def add(form: str, typed: list[str]) -> None:
    """Keep it as the last; a disk that is full or read-only keeps nothing."""
    path = state_file("typed.json")
    with _writing, contextlib.suppress(OSError):
        known = {}
        with contextlib.suppress(OSError, ValueError):
            known = json.loads(path.read_text(encoding="utf-8"))
        known = known if isinstance(known, dict) else {}
        others = [texts for texts in load(form) if texts != typed]
        make_folder(path)
        new = path.with_name(f"{path.name}.{os.getpid()}")
        new.write_text(json.dumps({**known, form: [*others, typed][-MOST:]}), encoding="utf-8")
        new.replace(path)
