"""The messages on the socket: one JSON object a line. See docs/protocol.md."""

from __future__ import annotations

import json

from archo_tui.base.surrogates import has_lone_surrogate
from archo_tui.robot.stop.words import is_stop_text

TYPE_CHECKING = False  # `typing` takes longer to load than all that a client needs.
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

PROTOCOL = 1
LONGEST_WAIT = 1e9  # Seconds.
DONE, FAILED, MISUSED, UNREACHED, RAN_OUT, ENDED, INTERRUPTED = 0, 1, 2, 3, 4, 5, 130
# In place of an outcome's code:
LOST = "lost"  # The console ends, or its screen was restarted.
NOT_REACHED = "unreached"  # A client's own word, never on a socket.
WATCHING = "watching"  # An outcome's code: the console sends no command.
GONE = "the console is gone; the robot may still be moving"
RESTARTS = "the console restarts; the robot may still be moving"
YES_WORDS = ("y", "yes")  # What a person may type as an answer.
GOOD = ("done", "accepted", "arrived")
EXITS = {
    **dict.fromkeys(GOOD, DONE),
    "misuse": MISUSED,
    "ran_out": RAN_OUT,
    LOST: UNREACHED,
    NOT_REACHED: UNREACHED,
    "cancelled": ENDED,
    "held": ENDED,
}  # Exit codes; every other code has FAILED.


def is_valid_timeout(timeout: object) -> bool:
    """Return True for a number of seconds from 0 to LONGEST_WAIT; a bool is no number."""
    is_number = isinstance(timeout, (int, float)) and not isinstance(timeout, bool)
    return is_number and 0 <= timeout <= LONGEST_WAIT  # type: ignore[operator]


def timeout_of(request: Mapping[str, Any]) -> float | None:
    """Return the timeout of a request in seconds; None without one; ValueError if it is no time."""
    timeout: float | None = request.get("timeout")
    if timeout is not None and not is_valid_timeout(timeout):
        raise ValueError(f"timeout: not a time in s: {str(timeout)[:40]}")
    return timeout


def encode(message: dict[str, Any]) -> bytes:
    """Return a message as a line of JSON in UTF-8; a lone surrogate becomes `?`."""
    return json.dumps(message, ensure_ascii=False).encode("utf-8", "replace") + b"\n"


def decode(data: bytes) -> dict[str, Any]:
    """Return the message in a line; ValueError if it is not a JSON object, or nested too deeply."""
    try:
        found = json.loads(data)
    except RecursionError:
        raise ValueError("too deep") from None
    if not isinstance(found, dict):
        raise ValueError("expected a JSON object")
    return found


def words_of(request: Mapping[str, Any]) -> list[str]:
    """Return the words of a request: a verb and its arguments; ValueError if they are not valid."""
    words = request.get("words")
    if not (isinstance(words, list) and words and all(isinstance(word, str) for word in words)):
        raise ValueError('expected {"id": ..., "words": ["status"]}')
    if any(map(has_lone_surrogate, words)):
        raise ValueError("words: they contain a lone surrogate, half of a character")
    return words


def is_stop(request: Mapping[str, Any]) -> bool:
    """Return True for the request of a STOP, in any spelling that `stop.words.is_stop` takes.

    Words that are no texts are skipped, and `words` may be a text.
    """
    words = request.get("words")
    if isinstance(words, list):
        words = " ".join(word for word in words if isinstance(word, str))
    return isinstance(words, str) and is_stop_text(words.replace("\0", ""))
