"""What is said on the socket: one JSON object a line. See docs/protocol.md."""

from __future__ import annotations

import json

TYPE_CHECKING = False  # without typing, which takes longer to load than all that a client needs
if TYPE_CHECKING:
    from typing import Any

PROTOCOL = 1
LONGEST = 64 * 1024  # bytes of a line
DONE, FAILED, MISUSED, UNREACHED, RAN_OUT, ENDED, INTERRUPTED = 0, 1, 2, 3, 4, 5, 130
LOST = "lost"  # in place of an outcome's code: the console ends, or its screen was restarted
GONE = "the console is gone; the robot may still be moving"
EXITS = {
    "done": DONE,
    "accepted": DONE,
    "arrived": DONE,
    "misuse": MISUSED,
    "ran_out": RAN_OUT,
    LOST: UNREACHED,
    "cancelled": ENDED,
    "held": ENDED,
}  # exit codes; of every other code it is FAILED


def line(said: dict[str, Any]) -> bytes:
    """A message as it is sent."""
    return json.dumps(said, ensure_ascii=False).encode("utf-8", "replace") + b"\n"


def has_half(word: str) -> bool:
    """True when half a character, a lone surrogate, is in it: bytes that are no text."""
    return any("\ud800" <= char <= "\udfff" for char in word)


def words_of(request: dict[str, Any]) -> list[str]:
    """What is asked for. Raises ValueError when that is none."""
    words = request.get("words")
    if not (isinstance(words, list) and words and all(isinstance(word, str) for word in words)):
        raise ValueError('expected {"id": ..., "words": ["status"]}')
    if any(map(has_half, words)):
        raise ValueError("words: half a character, a lone surrogate, is in them")
    return words


def is_stop(request: dict[str, Any]) -> bool:
    """True for STOP, however it is spelled and whatever follows it."""
    words = request.get("words")
    first = words[0] if isinstance(words, list) and words else None
    return isinstance(first, str) and first.strip(" .!").lower() == "stop"


def message(data: bytes) -> dict[str, Any]:
    """A message that was read. Raises ValueError when it is none."""
    try:
        found = json.loads(data)
    except RecursionError:
        raise ValueError("too deep") from None
    if not isinstance(found, dict):
        raise ValueError("expected a JSON object")
    return found
