"""The console in a test: real keys in, the screen's text out."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from rclpy.node import Node
from rich.cells import cell_len
from textual import events
from textual.app import App
from textual.keys import REPLACED_KEYS, _get_unicode_name_from_key
from textual.pilot import Pilot
from textual.screen import Screen

from archo_tui.base.handover import Handover
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.keyed_app import HELD
from archo_tui.screen.main import PANELS
from archo_tui.screen.widgets.panel import Panel
from archo_tui.screen.widgets.rows import Rows
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.quiet import Quiet
from tests.support.stand_in import Made
from tests.support.stub import sized
from tests.support.waiting import DEADLINE, wait_until

N = TypeVar("N", bound=Node)
# the keys of all panels, as the footer has them
PANEL_KEYS = f"1-{len(PANELS)}"
# the first reading of the battery comes at once, not within a second
AT_ONCE = ("-p", "publish_period:=0.05")
# the textbook's move in a tenth of the time
FAST = ("-p", "feedback_period:=0.05", "-p", "time_scale:=75.0", *AT_ONCE)
# a way of 1.5 s: what is on its way is seen on a busy machine, too
BRISK = ("-p", "feedback_period:=0.1", "-p", "time_scale:=15.0")
# a route so long that keys always come in mid-move
LONG = ("-p", "route_length:=1000.0", "-p", "time_scale:=1.0")


def key_event(key: str) -> events.Key:
    """The event of a key by Textual's name for it, with the character that it types."""
    try:
        name = _get_unicode_name_from_key(REPLACED_KEYS.get(key, key))
        character: str | None = unicodedata.lookup(name)
    except KeyError:
        character = key if len(key) == 1 else None
    return events.Key(key, character)


def send(app: App[Any], *keys: str) -> None:
    """Press keys, all at once."""
    for key in keys:
        app.post_message(key_event(key))


def click(app: App[Any], x: int, y: int) -> None:
    """Press and release the left button there, at once."""
    for kind in (events.MouseDown, events.MouseUp):
        app.post_message(kind(None, x, y, 0, 0, 1, False, False, False, screen_x=x, screen_y=y))


def focused_panel(app: ArchoApp) -> int:
    """The number of the panel that has the focus; 0 for none."""
    ancestors = [] if app.focused is None else app.focused.ancestors_with_self
    return next((node.number for node in ancestors if isinstance(node, Panel)), 0)


class Console:
    """An operator in front of the console."""

    def __init__(self, app: ArchoApp, pilot: Pilot[None], session: Session) -> None:
        self.app, self.pilot, self.session = app, pilot, session
        self._quiet = Quiet(app)
        self._last, self._pressed = "", 0.0

    @property
    def text(self) -> str:
        """What the screen shows, line by line."""
        return screen_text(self.app)

    @property
    def words(self) -> str:
        """The same with single blanks: for what stands at both ends of a panel."""
        return re.sub(" +", " ", self.text)

    def line(self, part: str) -> str:
        """The first line of the screen with that text in it, or an empty string."""
        return next((line for line in self.text.splitlines() if part in line), "")

    @property
    def focused_panel(self) -> int:
        """The number of the panel that has the focus; 0 for none."""
        return focused_panel(self.app)

    @property
    def parameters(self) -> list[str]:
        """The names of the parameters that are listed."""
        return [parameter.name for parameter in self.app.query_one("#parameters", Rows).items]

    async def press(self, *keys: str) -> None:
        """Press keys one after the other; the same again only when it was let go."""
        # what a person must let go before it acts again
        once = {
            "enter",
            *(command.key for command in self.app.registry if command.waits_for_answer),
        }
        for key in keys:
            if key == self._last and key in once:
                # since the console took it, which on a loaded machine is after it was sent
                await self._quiet.settle()
                await self.at(max(self._pressed, self.app._last_typed) + HELD)
            send(self.app, key)
            await self._quiet.settle()
            self._last, self._pressed = key, clock.seconds()  # when the console has taken it

    async def at(self, when: float) -> None:
        """Wait until that time (s) of the robot's."""
        await self._quiet.until(lambda: clock.seconds() >= when, str)

    def send(self, *keys: str) -> None:
        """Press keys, all at once: as they come over a slow link."""
        send(self.app, *keys)
        self._last, self._pressed = keys[-1], clock.seconds()

    async def settle(self) -> None:
        """Let everything be done that is to be done before time moves on."""
        await self._quiet.settle()

    async def type(self, text: str) -> None:
        """Type text, all at once."""
        send(self.app, *text)
        self._last = text[-1:] or self._last
        await self._quiet.settle()

    async def until(
        self, condition: str | Callable[[], object], deadline: float = DEADLINE
    ) -> None:
        """Wait until the screen shows a text or a condition holds; a virtual clock moves on."""
        wanted = (lambda: condition in self.text) if isinstance(condition, str) else condition
        await self._quiet.until(wanted, lambda: f"{condition!r}:\n{self._seen()}", deadline)

    def _seen(self) -> str:
        """What a failure says: the last key, the focus, and the screen."""
        app = self.app
        since = clock.seconds() - app._last_typed
        held = ", held" if app.repeated else ""
        return f"{app._last_key!r} {since:.2f} s ago{held}; focus on {app.focused!r}\n{self.text}"

    async def ready(self) -> None:
        """Wait until the robot is seen: data, parameters, services."""
        await self.until(lambda: _is_seen(self.app.view.snapshot))


def _is_seen(snapshot: Snapshot) -> bool:
    return (
        snapshot.battery.received is not None
        and snapshot.motion.received is not None
        and snapshot.parameter("ticks_per_revolution") is not None
        and len(snapshot.offered) == 7
    )


_read: WeakKeyDictionary[Any, tuple[object, str]] = WeakKeyDictionary()  # by screen


def screen_text(app: App[Any]) -> str:
    """What a screen shows, line by line; read again only after it was drawn again."""
    screen = app.screen
    draws = getattr(screen, "draws", -1)  # nobody counts them outside of a test
    # What was read between a new size and its layout is no more than a blank.
    state = draws, screen.size, screen._compositor.size
    if draws < 0 or _read.get(screen, (None, ""))[0] != state:
        _read[screen] = state, _painted(screen)
    return _read[screen][1]


def _painted(screen: Screen[Any]) -> str:
    """The text of all widgets, those in front over those behind; looks are left out."""
    width, height = screen.size
    cells = [[" "] * width for _ in range(height)]
    renders = [*screen._compositor._get_renders(screen.size.region)]
    for region, clip, strips in reversed(renders):  # from back to front
        # Just after the terminal became smaller, a dialog may still be where it was.
        part = region.intersection(clip).intersection(screen.size.region)
        for y, strip in zip(part.line_range, strips, strict=False):
            cells[y][part.x : part.right] = _cells(strip.text, part.width)
    return "\n".join("".join(line) for line in cells)


def _cells(text: str, width: int) -> list[str]:
    """A text cell by cell; the second cell of a wide character is empty."""
    if cell_len(text) != len(text):
        wide = [(char, cell_len(char)) for char in text]
        text_cells = [part for char, size in wide for part in (char, "")[:size]]
    else:
        text_cells = [*text]
    return (text_cells + [" "] * width)[:width]


@asynccontextmanager
async def console(
    *ros_args: str,
    size: tuple[int, int] = (120, 36),
    node_makers: Sequence[Any] = (),
    params_files: Sequence[Path] = (),
    node_files: Sequence[Path] = (),
    only: bool = False,
    robot: Path | None = None,
    watch: bool = False,
    attach: bool = False,
    domain_id: int | None = None,
    wait: bool = True,
    remote: bool = False,
    record: Path | None = None,
    in_field: bool = False,
    handover: Handover | None = None,
) -> AsyncIterator[Console]:
    """The console with ARCHO's nodes (or others), on a graph of its own.

    Unless it starts `in_field`, somebody has left the goal's field, and digits lead to panels.
    """
    options = Options(
        engine=chosen.ENGINE,
        attach=attach,
        domain_id=chosen.next_domain() if domain_id is None else domain_id,
        params_files=params_files,
        ros_args=ros_args,
        node_makers=node_makers,
        node_files=node_files,
        only=only,
        robot=robot,
        watch=watch,
        remote=remote,
        record=record,
        handover=handover,
    )
    with Session(options, clock.current) as session:
        if wait and clock.current is not None:
            # The screen is laid out and drawn once, not with each thing that becomes known.
            wait_until(lambda: _is_seen(session.robot.snapshot))
        with sized(size):
            app = ArchoApp(session.station)
        app.main.starts_in_field = in_field and not watch
        app.animation_level = "none"
        app.NOTIFICATION_TIMEOUT = DEADLINE  # type: ignore[misc]  # s: a busy machine may look late
        async with app.run_test(size=size) as pilot:
            operator = Console(app, pilot, session)
            if wait:
                await operator.ready()
            yield operator


@asynccontextmanager
async def console_with(
    kind: Callable[..., N], *names: str, **options: Any
) -> AsyncIterator[tuple[Console, N]]:
    """The console on a robot of one node, and this node, once all that it offers is seen."""
    made = Made(kind)
    async with console(node_makers=[made], wait=False, **options) as op:

        def is_seen() -> bool:
            seen = op.app.view.snapshot
            return {*names} <= {*seen.offered, *seen.actions, *seen.services}

        await op.until(is_seen)
        yield op, made.node
