"""What happens to the robot that no console has told of: somebody else did it. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from archo_tui.robot.state import Motion
from archo_tui.robot.values import text_of

# s for a console to say that it was its doing, before and after: STOP waits 3 s for its servers
_PATIENCE = 4.0
_UNANSWERED = "no answer in "  # of what was not answered in time, and may be done later:
_LATE = 20.0  # s later
_GAP = 2.0  # s without a word, after which the robot's node may have been restarted


class _Seen(NamedTuple):
    words: tuple[str, ...]  # one of them is in a console's line about it
    said: str
    at: float  # monotonic s


class Others:
    """Holds what changed against what consoles, this one too, said they did."""

    def __init__(self, commands: Iterable[str]) -> None:
        """`commands` are the titles of the robot file's own: one of them may zero the count."""
        self._commands = tuple(title.lower() for title in commands)
        self._told: list[tuple[str, float]] = []
        self._seen: list[_Seen] = []
        self._motion = Motion()

    def heard(self, text: str, now: float) -> None:
        """A console's line about a command of its own."""
        self._told = [told for told in self._told if now - told[1] < _LATE + 2 * _PATIENCE]
        self._told.append((text.lower(), now))

    def motion(self, motion: Motion, now: float) -> None:
        """How the robot moves now."""
        before, self._motion = self._motion, motion
        if now - (before.received or 0.0) > _GAP:
            return  # it may be another node by now
        if before.stopped is False and motion.stopped:
            self._see(("stop",), "stopped by another client", now)
        if before.stopped and motion.stopped is False:
            self._see(("release",), "stop released by another client", now)
        if before.count and motion.count == 0:
            change = f"{before.count} -> 0"
            self._see(self._commands, f"encoder reset by another client ({change})", now)

    def parameter(self, node: str, name: str, old: Any, new: Any, now: float) -> None:
        """A node says that a parameter has changed."""
        change = f"{text_of(old)} -> {text_of(new)}"
        said = f"{node.lstrip('/')} {name} changed by another client ({change})"
        self._see((f"{name.lower()} ",), said, now)

    def _see(self, words: tuple[str, ...], said: str, now: float) -> None:
        self._seen.append(_Seen(words, said, now))

    def unexplained(self, now: float) -> list[str]:
        """What was seen a while ago, and is nobody's by now."""
        due = [seen for seen in self._seen if now - seen.at >= _PATIENCE]
        self._seen = [seen for seen in self._seen if now - seen.at < _PATIENCE]
        return [seen.said for seen in due if not self._is_told(seen)]

    def _is_told(self, seen: _Seen) -> bool:
        return any(
            -_PATIENCE <= seen.at - at <= (_LATE if _UNANSWERED in text else _PATIENCE)
            and any(word in text for word in seen.words)
            for text, at in self._told
        )
