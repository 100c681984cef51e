"""The text of a proposed robot file: YAML with the reason of each part as a comment above it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from textwrap import indent

from archo_tui.robot_file.dump import plain
from archo_tui.robot_file.load import parse
from archo_tui.robot_file.model import RobotFile
from archo_tui.robot_file.proposal import Entry, Proposal
from archo_tui.yaml_text import dump as yaml_dump

_LISTS = ("goals", "commands")
_NO_STOP = (
    "No service that looks like a STOP was seen: without one, ctrl+x cancels every goal instead."
)
_MOST = 200  # Unknown topics, services and actions that are listed; the rest is counted.


def text_of(proposal: Proposal, head: str) -> str:
    """Return the text of a proposed robot file, with a comment above each part.

    Parts that are not sure, `head` and the first 200 unknown lines become comments. ArchoError if
    the text would not load.
    """
    name = proposal.namespace.rpartition("/")[2] or RobotFile.name
    parts = [
        _comment(head),
        yaml_dump.block({"version": RobotFile.version, "name": name}),
        *_parts(proposal.entries),
        "" if any(entry.part == "stop" for entry in proposal.entries) else _comment(_NO_STOP),
        *_unknown(proposal.unknown),
    ]
    text = "".join(parts)
    parse(text, Path("the proposed file"))
    return text


def _parts(entries: tuple[Entry, ...]) -> Iterator[str]:
    for part, group in groupby(entries, key=lambda entry: entry.part):
        if part in _LISTS:
            yield f"{part}:\n"
            for entry in group:
                item = yaml_dump.mixed([plain(entry.value)])
                item = item if entry.is_sure else _comment(item)
                yield indent(_comment(entry.reason) + item, "  ")
            continue
        for entry in group:
            value = plain(entry.value)
            # `mixed` writes a mapping of one name in braces, which nothing can follow in a file.
            write = yaml_dump.block if isinstance(value, str) else yaml_dump.mixed
            text = write({part: value})
            yield _comment(entry.reason) + (text if entry.is_sure else _comment(text))


def _unknown(lines: tuple[str, ...]) -> Iterator[str]:
    if not lines:
        return
    yield _comment("Seen besides, and not described:")
    yield "".join(_comment(f"  {line}") for line in lines[:_MOST])
    if len(lines) > _MOST:
        yield _comment(f"  and {len(lines) - _MOST} more")


def _comment(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())
