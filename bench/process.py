"""The console in a terminal, and what it costs."""

from __future__ import annotations

import signal
import time
from pathlib import Path

from tests.support import chosen
from tests.support.terminal import Terminal

_SYNCHRONIZED = "\x1b[?2026;2$y"  # The terminal's answer: updates can be taken as one.
_UPDATE_ENDS = b"\x1b[?2026l"


def cpu(pid: int) -> float:
    """Return the CPU of all threads of a process so far, in seconds."""
    used = 0
    for task in Path(f"/proc/{pid}/task").iterdir():
        used += int((task / "schedstat").read_text().split()[0])
    return used / 1e9


class Program:
    """The console, or with `code` that ends in `sys.exit()` another program."""

    def __init__(
        self,
        *words: str,
        code: str = "",
        engine: str = "embedded",
        size: tuple[int, int] = (120, 36),
    ) -> None:
        chosen.ENGINE = engine
        self.began = time.perf_counter()
        self.terminal = Terminal(*words, code=code, size=size, fresh=True)
        self.terminal.write(_SYNCHRONIZED)

    def __enter__(self) -> Program:
        return self

    def __exit__(self, *_: object) -> None:
        self.terminal.kill(signal.SIGKILL)
        self.terminal.exit_code()
        self.terminal.close()

    def until(self, text: str) -> float:
        """Read until a text was drawn since the last `press`; return the seconds since then."""
        while text.encode() not in self.terminal.output:
            assert time.perf_counter() - self.began < 60, self.terminal.text[-2000:]
            self.terminal.read(0.001)
        return time.perf_counter() - self.began

    def frame(self, text: str) -> None:
        """Read until an update with a text has been drawn whole."""
        while _UPDATE_ENDS not in self.terminal.output.partition(text.encode())[2]:
            self.until(text)
            self.terminal.read(0.01)

    def press(self, keys: str, effect: str) -> float:
        """Return the seconds from a key to what it draws."""
        self.read(0.3)
        self.terminal.output, self.began = b"", time.perf_counter()
        self.terminal.write(keys)
        return self.until(effect)

    def read(self, seconds: float) -> None:
        """Take what is drawn in that time; only its end is kept."""
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            self.terminal.read(0.02)

    def load(self, seconds: float) -> float:
        """Return the CPU in that time, as a part of one core."""
        before, began = cpu(self.terminal.pid), time.perf_counter()
        self.read(seconds)
        return (cpu(self.terminal.pid) - before) / (time.perf_counter() - began)
