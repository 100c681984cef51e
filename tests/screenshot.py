"""The pictures in README and docs: `python -m tests.screenshot screenshot.svg`.

The name of the file says which one: see PICTURES.
"""

from __future__ import annotations

import asyncio
import os
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from archo_tui.ros import engine
from tests.support import chosen

if TYPE_CHECKING:
    from tests.support.console import Console


_BRISK = ("-p", "drain_min:=1.0", "-p", "drain_max:=1.6", "-p", "time_scale:=4.0")
_LAMP = """\
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32


class Lamp(Node):
    def __init__(self):
        super().__init__("lamp")
        self.brightness = self.create_publisher(Float32, "brightness", 10)
        self.create_timer(0.5, self.on_timer)

    def on_timer(self):
        self.brightness.publish(Float32(data=0.8))
        self.get_logger().info("shining")


def main():
    rclpy.init()
    rclpy.spin(Lamp())
"""


async def overview() -> str:
    """Return the console a while after several shelves were typed."""
    from tests.support.console import console  # Not before the engine is chosen.

    async with console(*_BRISK, size=(160, 48)) as op:
        await op.press("g")
        await op.type("7 3 12 9")
        await op.press("enter")
        await op.until("MOVING to 12")
        await op.until("m left of")
        await op.press("escape")
        await op.until("m left of")
        return op.app.export_screenshot()


async def first_drive() -> str:
    """Return the console on the first drive, on its way to shelf 12."""
    from tests.support.console import console

    async with console("-p", "time_scale:=1.0", size=(100, 30), in_field=True) as op:
        await op.type("12")
        await op.press("enter")
        await op.until("MOVING to 12")
        await op.until(" 2 %")
        return op.app.export_screenshot()


async def replay() -> str:
    """Return the replay of a STOP."""
    from tests.replay.recorded import replay as replayed
    from tests.replay.recorded import written
    from tests.support.console import console

    async with console(*_BRISK) as op:
        await op.press("g", "1", "2", "enter")
        await op.until("MOVING to 12")
        await op.until("m left of")
        await op.press("ctrl+x")
        path = await written(op)
    async with replayed(path) as watcher:
        await watcher.press("m", "m", "m", "right")
        return watcher.app.export_screenshot()


async def own_nodes() -> str:
    """Return the console with a node of one's own, whose lines are among the events."""
    from tests.support.console import console

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "lamp.py"
        file.write_text(_LAMP)
        async with console(node_files=[file], size=(100, 30)) as op:
            await op.press("5")
            await op.until("shining   x 4")
            return op.app.export_screenshot()


ROBOT = [
    *("-p", "drain_min:=0.5", "-p", "drain_max:=0.6", "-p", "low_battery_threshold:=84.0"),
    *("-p", "route_length:=18.0", "-p", "time_scale:=1.0", "-p", "feedback_period:=0.1"),
]
# what is pressed, what is then seen (a pattern), and how long (s) the screen is shown
STORY: tuple[tuple[tuple[str, ...], str, float], ...] = (
    (("g", "1", "2"), "12", 2.0),
    (("enter",), " 1[0-9] %", 3.0),
    (("ctrl+p", "s", "p"), "max_speed", 2.5),
    (("enter",), "0.05 .. 2", 1.5),
    ((*"0.4",), "0.4", 1.5),
    (("enter",), "max_speed is 0.4, was 0.8", 2.5),
    ((), "LOW BATTERY", 3.0),
    (("a",), " 4[5-9] %", 1.5),
    (("ctrl+x",), "STOPPED", 4.0),
    (("R",), "Release", 2.5),
    (("y",), "● IDLE", 3.0),
)
# what the STOP has recorded: what is pressed, and how long (s) the screen is shown
PLAYED: tuple[tuple[tuple[str, ...], float], ...] = (((), 3.0), (("m",), 3.0), (("m", "m"), 3.5))
MOST = 400_000  # bytes
NO_BREAK = "\u00a0"
# of each picture, once is enough, or nobody sees it
_MORE = (
    r"<style>.*?</style>",
    r"<!--.*?-->",
    r'<clipPath id="[^"]*-line-[^"]*">.*?</clipPath>',
    r' clip-path="url\(#[^)]*-line-[^)]*\)"',
    r" {2,}",
)
_RULE = re.compile(r"\.(terminal-\d+-r\d+) \{(.*?)\}")
_PART = re.compile(r"<(text|rect) [^>]*?(/>|>.*?</\1>)", re.DOTALL)


async def frames() -> list[str]:
    """The screen after each step of the story, as SVG."""
    from tests.replay.recorded import replay as replayed
    from tests.replay.recorded import written
    from tests.support.console import console

    found = []
    async with console(*ROBOT) as op:
        for keys, seen, _ in STORY:
            for key in keys:
                await op.press(key)
            await op.until(partial(_shows, op, seen))
            found.append(op.app.export_screenshot(simplify=True))
        path = await written(op)
    async with replayed(path) as watcher:
        for keys, _ in PLAYED:
            await watcher.press(*keys)
            found.append(watcher.app.export_screenshot(simplify=True))
    return found


def _shows(op: Console, pattern: str) -> bool:
    return re.search(pattern, op.text) is not None


async def session() -> str:
    """Return a session as one moving picture; refuse one that a page would not load at once.

    Keys are pressed in the running console, and after each step its screen is kept; a style sheet
    shows the screens one after the other, for ever.
    """
    text = joined(await frames(), [*(s for _, _, s in STORY), *(s for _, s in PLAYED)])
    assert len(text.encode()) <= MOST, "too many bytes: leave screens out"
    return text


def joined(pictures: list[str], seconds: list[float]) -> str:
    """One SVG that shows each for so long; what several have in it stands there once."""
    whole, begin, styles, shown = sum(seconds), 0.0, [], []
    fonts = re.search(r"@font-face.*?(?=\.terminal)", pictures[0], re.DOTALL)
    box = re.search(r'viewBox="[^"]*"', pictures[0])
    assert fonts is not None
    assert box is not None
    colours: dict[str, str] = {}  # the class of each style
    inside = [_inside(picture, colours) for picture in pictures]
    counted = Counter(part[0] for picture in inside for part in _PART.finditer(picture))
    named = {part: f"p{n}" for n, part in enumerate(p for p in counted if counted[p] > 1)}
    for number, (picture, length) in enumerate(zip(inside, seconds, strict=True)):
        end = begin + length
        turns = f"0% {{ visibility: hidden }} {100 * begin / whole:.2f}% {{ visibility: visible }}"
        turns += f" {min(100 * end / whole, 99.99):.2f}% {{ visibility: hidden }}"
        styles.append(f"@keyframes s{number} {{ {turns} }}")
        styles.append(f".s{number} {{ animation: s{number} {whole:g}s step-end infinite }}")
        short = _PART.sub(
            lambda p: f'<use href="#{named[p[0]]}"/>' if p[0] in named else p[0], picture
        )
        shown.append(f'<g class="s{number}">{short}</g>')
        begin = end
    styles += [f".{name} {{{style}}}" for style, name in colours.items()]
    base = re.search(r"\.terminal-\d+-matrix \{.*?\}", pictures[0], re.DOTALL)
    title = re.search(r"\.terminal-\d+-title \{.*?\}", pictures[0], re.DOTALL)
    assert base is not None
    assert title is not None
    own = re.sub(r"terminal-\d+", "terminal", base[0] + title[0])
    sheet = "\n".join(["<style>", fonts[0], own, *styles, "</style>"])
    head = f'<svg class="rich-terminal" {box[0]} xmlns="http://www.w3.org/2000/svg">'
    parts = [re.sub(r"^<\w+", rf'\g<0> id="{name}"', part) for part, name in named.items()]
    defined = "\n".join(["<defs>", *parts, "</defs>"])
    return "\n".join([head, sheet, defined, *shown, "</svg>\n"])


def _inside(picture: str, colours: dict[str, str]) -> str:
    """What is drawn, with the classes of `colours`, to which new ones are added."""
    names = {}
    for name, style in _RULE.findall(picture):
        names[name] = colours.setdefault(style.strip(), f"c{len(colours)}")
    inner = picture.partition(">")[2].rpartition("</svg>")[0]
    for more in _MORE:
        inner = re.sub(more, "", inner, flags=re.DOTALL)
    inner = re.sub(r"terminal-\d+-r\d+", lambda found: names[found[0]], inner)
    inner = re.sub(r"terminal-\d+", "terminal", inner)
    return inner.replace("&#160;", NO_BREAK)


def at_home(home: str) -> None:
    """A user who has just installed it, in a terminal of any colour."""
    chosen.ENGINE = "embedded"
    engine.activate("embedded", hosting=True)
    os.environ |= {"HOME": home, "XDG_STATE_HOME": home, "XDG_CONFIG_HOME": home}
    os.environ |= {"TERM": "xterm-256color", "COLORTERM": "truecolor"}


PICTURES: dict[str, Callable[[], Awaitable[str]]] = {
    "screenshot.svg": overview,
    "first_drive.svg": first_drive,
    "replay.svg": replay,
    "own_nodes.svg": own_nodes,
    "session.svg": session,
}


def main() -> None:
    """Draw the picture that the file's name says."""
    path = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as home:
        at_home(home)
        path.write_text(asyncio.run(_drawn(PICTURES[path.name])), encoding="utf-8")


async def _drawn(draw: Callable[[], Awaitable[str]]) -> str:
    return await draw()


if __name__ == "__main__":
    main()
