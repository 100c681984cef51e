"""The recordings as `archo-tui recordings` prints them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from datetime import datetime

from archo_tui.errors import ArchoError
from archo_tui.paths import state_file
from archo_tui.recording import store
from archo_tui.recording.box import KEPT


def lines(*, as_json: bool) -> Iterator[str]:
    """`2026-11-22_03-12-07_STOP   65 s    212 kB   STOP`, the newest first."""
    found = _listed()[::-1]
    widest = max((len(one.name) for one in found), default=0)
    for one in found:
        if as_json:
            yield json.dumps(
                {
                    "name": one.name,
                    "path": str(one.folder),
                    "start": datetime.fromtimestamp(one.start).astimezone().isoformat(),
                    "seconds": one.seconds,
                    "why": one.why,
                    "kept": one.kept,
                    "messages": one.messages,
                    "bytes": one.bytes,
                }
            )
        else:
            yield line(one, widest)
    if not found and not as_json:
        yield f"no recordings in {state_file('recordings')}"


def line(one: store.Recording, width: int) -> str:
    """With its name in so many cells."""
    size = f"{one.bytes / 1e6:7.1f} MB" if one.bytes >= 1e6 else f"{one.bytes / 1e3:7.0f} kB"
    kept = ", kept" if one.kept and KEPT not in one.why.split(", ") else ""
    return f"{one.name:<{width}}  {one.seconds:5.0f} s  {size}  {one.why}{kept}"


def delete(names: Sequence[str]) -> Iterator[str]:
    """Each by its name; says what went. Raises ArchoError before any goes."""
    known = {one.name: one for one in _listed()}
    for name in names:
        if name not in known:
            raise ArchoError(f"no recording is called {name} (see archo-tui recordings)")
    for name in names:
        try:
            store.delete(known[name])
        except OSError as error:
            raise ArchoError(f"{error.filename or name}: {error.strerror or error}") from None
        yield f"deleted {name}"


def _listed() -> list[store.Recording]:
    try:
        return store.listed(state_file("recordings"))
    except OSError as error:
        raise ArchoError(f"{error.filename}: {error.strerror}") from None
