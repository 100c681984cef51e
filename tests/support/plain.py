"""`--plain` in the test's own process: what is typed, and what is said."""

from __future__ import annotations

import asyncio
import os
import select
import sys
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from archo_tui.console.plain import Plain
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from archo_tui.station.station import Station
from tests.support import chosen, clock
from tests.support.quiet import Quiet


class Typed:
    """A person at standard input and output; the input is a pipe, or a terminal."""

    def __init__(self, station: Station, at_terminal: bool = False) -> None:
        self._at_terminal = at_terminal
        if at_terminal:
            self._typing, self._in = os.openpty()
        else:
            self._in, self._typing = os.pipe()
        self._has_ended = False  # the input
        self._reading, self._out = os.pipe()
        Quiet()  # from now on it knows of what is done on threads
        self._plain = Plain(station, self._in, self._out)
        self._follow_input()
        self._running = asyncio.ensure_future(self._plain.run())
        self._said, self._hearing = b"", threading.Lock()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _follow_input(self) -> None:
        """Know of what the input has read, and of which its thread has not told the loop yet."""
        self._is_told = True
        read: Any = self._plain._input
        keep, announce = read._keep, read._announce

        def kept(lines: list[bytes]) -> None:
            self._is_told = False
            keep(lines)

        def announced() -> None:
            announce()
            self._is_told = True

        read._keep, read._announce = kept, announced

    def _read(self) -> None:
        chunk = b"more"
        while chunk:
            if sys.platform != "win32":
                select.select([self._reading], [], [])
            with self._hearing:
                chunk = os.read(self._reading, 65536)
                self._said += chunk

    def type(self, text: str) -> None:
        """In one go."""
        os.write(self._typing, text.encode())
        echoed = b""
        while self._at_terminal and echoed.count(b"\n") < text.count("\n"):
            echoed += os.read(self._typing, 4096)  # only then it can be read at the other end

    async def enter(self, line: str, said: str) -> None:
        """Type a line, and wait until that is said."""
        self.type(f"{line}\n")
        await self.until(said)

    @property
    def station(self) -> Station:
        """What the person operates."""
        return self._plain._station

    @property
    def said(self) -> str:
        """All that was printed so far."""
        return self._said.decode(errors="replace")  # a letter may be half there

    async def until(self, text: str) -> None:
        """Wait until that is said."""
        await self.is_read()

        def is_said() -> bool:
            while not self._is_heard():  # by threads, before a virtual clock moves
                time.sleep(clock.look())
            return text in self.said

        await Quiet().until(is_said, lambda: f"{text!r}:\n{self.said}")

    async def is_read(self) -> None:
        """Wait until what was typed is read; only then a virtual clock may move."""
        while not ((self._plain._input.is_quiet and self._is_told) or self.is_over):
            await asyncio.sleep(clock.look())

    def _is_heard(self) -> bool:
        """True when all that was printed is in `said`."""
        if sys.platform == "win32":
            return True
        import fcntl
        import termios

        is_done = self._plain._output.is_done  # First: what is written then is in the pipe.
        with self._hearing:
            waits = any(fcntl.ioctl(self._reading, termios.FIONREAD, bytes(4)))
        return self.is_over or (is_done and not waits)

    @property
    def is_over(self) -> bool:
        """True after the end."""
        return self._running.done()

    def type_last(self, text: str) -> None:
        """Type it and close the input."""
        self.type(text)
        self._has_ended = True
        if self._at_terminal:
            os.write(self._typing, b"\x04")  # ctrl+d
        else:
            os.close(self._typing)
            self._typing = -1

    async def end(self, typed: str = "") -> int:
        """Type the last lines, close the input, and wait for the end; returns the exit code."""
        if not self._has_ended:
            self.type_last(typed)
        await self.is_read()
        await Quiet().until(self._running.done, lambda: f"the end:\n{self.said}")
        self._read_all()
        return await self._running

    def _read_all(self) -> None:
        if self._out >= 0:
            os.close(self._out)
            self._out = -1
            self._reader.join()

    async def close(self) -> None:
        """Leave nothing behind."""
        if not self._running.done():
            self._running.cancel()
            await asyncio.wait([self._running])
        self._read_all()
        if self._typing >= 0:
            os.close(self._typing)
        while self._plain._input.is_reading:  # a descriptor of that number may soon be another's
            await asyncio.sleep(clock.look())
        for descriptor in (self._in, self._reading):
            os.close(descriptor)


@asynccontextmanager
async def typing(station: Station, at_terminal: bool = False) -> AsyncIterator[Typed]:
    """Around what a person types to a station, and reads."""
    person = Typed(station, at_terminal)
    try:
        yield person
    finally:
        await person.close()


@asynccontextmanager
async def operated(
    *makers: Any, robot: Path | None = None, at_terminal: bool = False, **options: Any
) -> AsyncIterator[Typed]:
    """The same with a robot of these nodes, or the usual one."""
    given = {"domain_id": chosen.next_domain(), "node_makers": makers, **options}
    with Session(Options(engine=chosen.ENGINE, robot=robot, **given), clock.current) as session:
        async with typing(session.station, at_terminal) as person:
            yield person


async def plain(typed: str, *makers: Any, robot: Path | None = None, **options: Any) -> Any:
    """The exit code and the output of what is typed all at once."""
    async with operated(*makers, robot=robot, **options) as person:
        code = await person.end(typed)
        return code, person.said
