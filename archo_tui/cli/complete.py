"""The hidden `archo-tui __complete WORD ...`, which the script of a shell calls at a tab.

It takes half a second at most, prints nothing without an answer, and changes nothing on the robot.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import sys

from archo_tui.client import find
from archo_tui.client.connection import Unreached
from archo_tui.errors import ArchoError
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

_TIMEOUT = 0.25  # Seconds, twice: for the hello of a console, and for its answer.
# A robot chooses the names on its graph. A word that a shell could read as anything but itself is
# not offered.
_PLAIN_WORD = re.compile(r"[\w./:=+-]+", re.ASCII)


def print_candidates(words: Sequence[str]) -> int:
    """Print the words that may follow, except those that a shell interprets, and return 0."""
    with contextlib.suppress(argparse.ArgumentError, Unreached, ArchoError, OSError, ValueError):
        for word in _candidates(words):
            if _PLAIN_WORD.fullmatch(word):
                sys.stdout.write(f"{word}\n")
    return 0


def _candidates(words: Sequence[str]) -> Iterable[str]:
    *before, unfinished = words
    if before[:1] in (["replay"], ["recordings"]):
        from archo_tui.recordings.store import own_recordings

        return [recording.name for recording in own_recordings()]
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    for option in (*VERB_VALUES, "--engine", "--namespace"):
        parser.add_argument(option, default="")
    for flag in (*VERB_FLAGS, "--yes"):
        parser.add_argument(flag, action="store_true")
    options, line = parser.parse_known_args(before)
    selection = {"to": options.to or options.namespace, "engine": options.engine}
    with contextlib.closing(find.choose(selection, _TIMEOUT)) as console:
        for said in console.request(_TIMEOUT, complete=[*line, unfinished]):
            if isinstance(said.get("data"), list):
                return [word for word in said["data"] if isinstance(word, str)]
    return ()
