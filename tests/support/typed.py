"""Bytes for a Keyboard on a clock that the test moves, in the steps in which the driver asks."""

from __future__ import annotations

from textual import events
from textual.message import Message

from archo_tui.screen.terminal.keyboard import Keyboard

SOON, IDLE = 0.03, 0.1  # s, as the driver waits
LONG = 10.0  # s, after which nothing is open any more


class Typed:
    """What comes of what is typed."""

    def __init__(self) -> None:
        self.keyboard = Keyboard()
        self.now = 1000.0
        self.messages: list[Message] = []

    def wait(self, seconds: float) -> Typed:
        """Nothing comes for so long."""
        end = self.now + seconds
        while (step := SOON if self.keyboard.is_waiting else IDLE) < end - self.now:
            self.now += step
            self.messages += self.keyboard.on_silence(self.now)
        self.now = end
        return self

    def read(self, data: bytes | str, after: float = 0.0) -> Typed:
        """That is read at once, so many seconds after what came before."""
        self.wait(after)
        data = data.encode() if isinstance(data, str) else data
        self.messages += self.keyboard.feed(data, self.now)
        return self

    @property
    def keys(self) -> list[str]:
        """Which act, by now."""
        return [message.key for message in self.messages if isinstance(message, events.Key)]

    @property
    def text(self) -> str:
        """What a field would show of the keys."""
        keys = (message for message in self.messages if isinstance(message, events.Key))
        return "".join(key.character or "" for key in keys if key.is_printable)

    @property
    def pastes(self) -> list[str]:
        return [m.text for m in self.messages if isinstance(m, events.Paste)]

    @property
    def names(self) -> list[str]:
        """The classes of all that came."""
        return [type(message).__name__ for message in self.messages]


def typed(*reads: bytes | str, gap: float = 0.0) -> Typed:
    """What is read one after another, and silence."""
    keyboard = Typed()
    for number, data in enumerate(reads):
        keyboard.read(data, gap if number else 0.0)
    return keyboard.wait(LONG)
