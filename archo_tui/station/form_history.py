"""The texts that the operator typed into forms before, kept over restarts.

A few dozen entries are kept per form, in the state folder. All functions touch the disk and may be
called on any thread but the loop's.
"""

from __future__ import annotations

import contextlib
import json
import threading
from typing import Any

from archo_tui.paths import make_folder, state_file
from archo_tui.regular_files import read, replace

MAX_ENTRIES = 50  # That are kept of one form.
_FILE = "typed.json"

_writing = threading.Lock()  # Two goals may be sent at once.


def load(form: str) -> list[list[str]]:
    """Return the entries of a form, each as the texts of its fields, the oldest first.

    Empty also if the file is broken or cannot be read.
    """
    return _entries(_read(), form)


def add(form: str, typed: list[str]) -> None:
    """Add an entry as the newest of its form, in place of an equal one, MAX_ENTRIES at most.

    A broken file is replaced, which loses the entries of all forms. Errors of the disk are ignored.
    """
    path = state_file(_FILE)
    with _writing, contextlib.suppress(OSError):
        known = _read()
        others = [texts for texts in _entries(known, form) if texts != typed]
        make_folder(path)
        replace(path, json.dumps({**known, form: [*others, typed][-MAX_ENTRIES:]}))


def _read() -> dict[str, Any]:
    """Return the entries of all forms, by form; empty if the file is missing or broken."""
    with contextlib.suppress(OSError, ValueError, RecursionError):
        known = json.loads(read(state_file(_FILE)))
        return known if isinstance(known, dict) else {}
    return {}


def _entries(known: dict[str, Any], form: str) -> list[list[str]]:
    found = known.get(form)
    if not isinstance(found, list):
        return []
    return [list(map(str, texts)) for texts in found if isinstance(texts, list)][-MAX_ENTRIES:]
