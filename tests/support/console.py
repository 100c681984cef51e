"""The console in a test: real keys in, the screen's text out."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from textual import events
from textual.pilot import Pilot

from archo_tui.app import ArchoApp
from archo_tui.clock import Clock
from archo_tui.session import Options, Session
from archo_tui.widgets.panel import Panel
from tests.support import chosen
from tests.support.waiting import DEADLINE

# the textbook's move in a tenth of the time
FAST = ("-p", "feedback_period:=0.05", "-p", "time_scale:=75.0", "-p", "publish_period:=0.05")
# slow enough to press keys during a move
SLOW = ("-p", "feedback_period:=0.1", "-p", "time_scale:=2.0")


def send(app: ArchoApp, *keys: str) -> None:
    """Press keys, all at once."""
    for key in keys:
        app.post_message(events.Key(key, key if len(key) == 1 else None))


class Console:
    """An operator in front of the console."""

    def __init__(self, app: ArchoApp, pilot: Pilot[None], session: Session) -> None:
        self.app, self.pilot, self.session = app, pilot, session

    @property
    def text(self) -> str:
        """What the screen shows, line by line."""
        return "\n".join(strip.text for strip in self.app.screen._compositor.render_strips())

    def line(self, part: str) -> str:
        """The first line of the screen with that text in it, or an empty string."""
        return next((line for line in self.text.splitlines() if part in line), "")

    @property
    def focused_panel(self) -> int:
        """The number of the panel that has the focus; 0 for none."""
        focused = self.app.focused
        ancestors = [] if focused is None else focused.ancestors_with_self
        return next((node.number for node in ancestors if isinstance(node, Panel)), 0)

    async def press(self, *keys: str) -> None:
        """Press keys one after the other."""
        await self.pilot.press(*keys)

    def send(self, *keys: str) -> None:
        """Press keys without waiting for the screen to come to rest: it may never."""
        send(self.app, *keys)

    async def type(self, text: str) -> None:
        """Type text, character by character."""
        await self.pilot.press(*text)

    async def until(
        self, condition: str | Callable[[], object], deadline: float = DEADLINE
    ) -> None:
        """Wait until the screen shows a text or a condition holds."""
        wanted = (lambda: condition in self.text) if isinstance(condition, str) else condition
        end = time.monotonic() + deadline
        while not wanted():
            assert time.monotonic() < end, f"waited {deadline} s for {condition!r}:\n{self.text}"
            await self.pilot.pause(0.01)

    async def ready(self) -> None:
        """Wait until the robot is seen: data, parameters, services."""
        await self.until(
            lambda: (
                self.app.view.snapshot.battery.received is not None
                and self.app.view.snapshot.motor.received is not None
                and self.app.view.snapshot.parameter("ticks_per_revolution") is not None
                and len(self.app.view.snapshot.offered) == 7
            )
        )


@asynccontextmanager
async def console(
    *ros_args: str,
    size: tuple[int, int] = (120, 36),
    node_makers: Sequence[Any] = (),
    params_files: Sequence[Path] = (),
    clock: Clock | None = None,
    attach: bool = False,
    domain_id: int | None = None,
    wait: bool = True,
) -> AsyncIterator[Console]:
    """The console with ARCHO's nodes (or others), on a graph of its own."""
    options = Options(
        engine=chosen.ENGINE,
        attach=attach,
        domain_id=chosen.next_domain() if domain_id is None else domain_id,
        params_files=params_files,
        ros_args=ros_args,
        node_makers=node_makers,
    )
    with Session(options) as session:
        app = ArchoApp(session, clock)
        async with app.run_test(size=size, notifications=True) as pilot:
            operator = Console(app, pilot, session)
            if wait:
                await operator.ready()
            yield operator
