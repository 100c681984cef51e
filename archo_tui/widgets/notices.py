"""The notices: messages that are shown one at a time, and disappear after a while. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from textual.notifications import SeverityLevel

# A notice waits behind graver ones for so many times its duration: after that it would tell of what
# is long past.
_MAX_WAIT = 2
_GRAVITY: tuple[SeverityLevel, ...] = ("information", "warning", "error")


class Notice(NamedTuple):
    """A message to the operator."""

    text: str
    severity: SeverityLevel
    waiting: int = 0  # The number of other notices that have not gone yet.


@dataclass
class _Entry:
    notice: Notice
    duration: float  # Seconds for which it is shown.
    # The monotonic time at which it goes, shown or not; None until the first `Notices.update`. Its
    # first showing sets the time anew.
    until: float | None = None
    was_shown: bool = False


class Notices:
    """The notices that have not gone yet, of which the gravest is shown, and of equals the newest.

    The duration of a notice begins when it is first shown, and runs on while another one hides it.
    A notice that has waited for twice its duration is dropped unseen.
    """

    def __init__(self) -> None:
        self._entries: list[_Entry] = []

    def add(self, text: str, severity: SeverityLevel, duration: float) -> None:
        """Add a notice for `duration` seconds, in place of an equal one, with its blanks joined."""
        notice = Notice(" ".join(text.split()), severity)
        self._entries = [entry for entry in self._entries if entry.notice != notice]
        self._entries.append(_Entry(notice, duration))

    def update(self, now: float) -> Notice | None:
        """Remove the notices whose time is over, and return the one to show, whose time begins."""
        self._entries = [e for e in self._entries if e.until is None or now < e.until]
        entry = self._gravest()
        if entry is None:
            return None
        for waiting in self._entries:
            if waiting.until is None:
                waiting.until = now + _MAX_WAIT * waiting.duration
        if not entry.was_shown:
            entry.until, entry.was_shown = now + entry.duration, True
        return entry.notice._replace(waiting=len(self._entries) - 1)

    def dismiss(self) -> None:
        """Remove the notice that is shown, if any; the next one takes its place."""
        entry = self._gravest()
        if entry is not None:
            self._entries.remove(entry)

    def clear(self) -> None:
        """Remove all notices."""
        self._entries.clear()

    def _gravest(self) -> _Entry | None:
        """Return the newest of the gravest notices; None if there is none."""
        return max(
            reversed(self._entries), key=lambda e: _GRAVITY.index(e.notice.severity), default=None
        )
