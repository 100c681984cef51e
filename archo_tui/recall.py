"""What was typed into the goal's form before: kept over restarts, a few dozen at most."""

from __future__ import annotations

import contextlib
import json
import os

from archo_tui.paths import make_folder, state_file

MOST = 50


def load(form: str) -> list[list[str]]:
    """The texts of each time, the oldest first; nothing when there are none or they are broken."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        found = json.loads(state_file("typed.json").read_text(encoding="utf-8")).get(form, [])
        return [list(map(str, texts)) for texts in found if isinstance(texts, list)][-MOST:]
    return []


def save(form: str, typed: list[list[str]]) -> None:
    """Keep them; a disk that is full or read-only keeps nothing."""
    path = state_file("typed.json")
    with contextlib.suppress(OSError):
        known = {}
        with contextlib.suppress(OSError, ValueError):
            known = json.loads(path.read_text(encoding="utf-8"))
        known = known if isinstance(known, dict) else {}
        make_folder(path)
        new = path.with_name(f"{path.name}.{os.getpid()}")
        new.write_text(json.dumps({**known, form: typed[-MOST:]}), encoding="utf-8")
        new.replace(path)
