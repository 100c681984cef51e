"""The output of `archo-tui recordings`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from datetime import datetime

from archo_tui.errors import ArchoError
from archo_tui.paths import state_file
from archo_tui.recording import store
from archo_tui.recording.box import KEPT


def list_recordings(*, as_json: bool) -> Iterator[str]:
    """Yield a line for each recording, the newest first, or one that says that there is none.

    Args:
        as_json: True for a JSON object on each line, and no line if there is no recording; False
            for text such as `2026-11-22_03-12-07_STOP   65 s    212 kB   STOP`.

    Raises:
        ArchoError: The folder cannot be read.
    """
    found = _all_recordings()[::-1]
    widest = max((len(recording.name) for recording in found), default=0)
    for recording in found:
        if as_json:
            yield json.dumps(
                {
                    "name": recording.name,
                    "path": str(recording.folder),
                    "start": datetime.fromtimestamp(recording.start).astimezone().isoformat(),
                    "seconds": recording.seconds,
                    "why": recording.why,
                    "kept": recording.kept,
                    "messages": recording.messages,
                    "bytes": recording.bytes,
                }
            )
        else:
            yield format_line(recording, widest)
    if not found and not as_json:
        yield f"no recordings in {state_file('recordings')}"


def format_line(recording: store.Recording, width: int) -> str:
    """Return a line with a recording's name, length in seconds, size, and what triggered it.

    Args:
        recording: The recording.
        width: The cells of the name, to which it is padded.
    """
    length, size = f"{recording.seconds:5.0f} s", size_text(recording)
    return f"{recording.name:<{width}}  {length}  {size}  {why_text(recording)}"


def size_text(recording: store.Recording) -> str:
    """Return the size on the disk in 10 cells: `    212 kB`."""
    if recording.bytes >= 1e6:
        return f"{recording.bytes / 1e6:7.1f} MB"
    return f"{recording.bytes / 1e3:7.0f} kB"


def why_text(recording: store.Recording) -> str:
    """Return what triggered a recording, followed by `, kept` if the operator kept it besides."""
    is_kept = recording.kept and KEPT not in recording.why.split(", ")
    return f"{recording.why}{', kept' if is_kept else ''}"


def recording_names() -> list[str]:
    """Return the names of all recordings, the newest first.

    Raises:
        ArchoError: The folder cannot be read.
    """
    return [recording.name for recording in _all_recordings()[::-1]]


def delete_named(names: Sequence[str]) -> Iterator[str]:
    """Delete recordings one after the other, and yield a line for each.

    It is a generator: nothing happens before the first line is taken.

    Args:
        names: Their names; nothing is deleted if one of them is unknown.

    Raises:
        ArchoError: A name is unknown. Or the disk refuses one; those before it are deleted then.
    """
    known = {recording.name: recording for recording in _all_recordings()}
    for name in names:
        if name not in known:
            raise ArchoError(f"no recording is called {name} (see archo-tui recordings)")
    for name in dict.fromkeys(names):
        try:
            store.delete(known[name])
        except OSError as error:
            raise ArchoError(f"{error.filename or name}: {error.strerror or error}") from None
        yield f"deleted {name}"


def _all_recordings() -> list[store.Recording]:
    try:
        return store.list_recordings(state_file("recordings"))
    except OSError as error:
        raise ArchoError(f"{error.filename}: {error.strerror}") from None
