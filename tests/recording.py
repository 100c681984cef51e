"""A recorded session as one moving picture: `python -m tests.recording session.svg`.

Keys are pressed in the running console, and after each step its screen is kept; a style sheet shows
the screens one after the other, for ever.
"""

from __future__ import annotations

import asyncio
import os
import re
import sys
import tempfile
from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from archo_tui.ros import engine
from tests.support import chosen

if TYPE_CHECKING:
    from tests.support.console import Console

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
    from tests.replay.recorded import replay, written
    from tests.support.console import console  # not before the engine is chosen

    found = []
    async with console(*ROBOT) as op:
        for keys, seen, _ in STORY:
            for key in keys:
                await op.press(key)
            await op.until(partial(_shows, op, seen))
            found.append(op.app.export_screenshot(simplify=True))
        path = await written(op)
    async with replay(path) as watcher:
        for keys, _ in PLAYED:
            await watcher.press(*keys)
            found.append(watcher.app.export_screenshot(simplify=True))
    return found


def _shows(op: Console, pattern: str) -> bool:
    return re.search(pattern, op.text) is not None


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


def main() -> None:
    """Record, and refuse a file that a page would not load at once."""
    with tempfile.TemporaryDirectory() as home:
        at_home(home)
        pictures = asyncio.run(frames())
    text = joined(pictures, [*(s for _, _, s in STORY), *(s for _, s in PLAYED)])
    size = len(text.encode())
    if size > MOST:
        sys.exit(f"{size} bytes are too many: leave screens out")
    Path(sys.argv[1]).write_text(text, encoding="utf-8")
    print(f"{sys.argv[1]}: {len(pictures)} screens, {size} bytes")


if __name__ == "__main__":
    main()
