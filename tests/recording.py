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
from pathlib import Path

from tests.support import chosen

ROBOT = [
    *("-p", "drain_min:=0.5", "-p", "drain_max:=0.6", "-p", "low_battery_threshold:=84.0"),
    *("-p", "route_length:=60.0", "-p", "time_scale:=4.0", "-p", "feedback_period:=0.1"),
]
# what is pressed, what is then seen, and how long (s) the screen is shown
STORY: tuple[tuple[tuple[str, ...], str, float], ...] = (
    ((), "IDLE", 2.0),
    (("g", "1", "2"), "12", 1.0),
    (("enter",), "MOVING to 12", 0.8),
    ((), " 15%", 0.8),
    ((), " 25%", 0.8),
    (("escape", "4", "slash", *"max_sp", "enter", "enter"), "0.05 .. 2", 1.2),
    (("ctrl+u", *"0.4"), "0.4", 1.2),
    (("enter",), "max_speed is 0.4", 1.5),
    ((), "LOW BATTERY", 2.0),
    (("a",), " 50%", 1.2),
    (("ctrl+x",), "STOPPED", 2.5),
    (("R",), "Release", 1.5),
    (("tab", "enter"), "● IDLE", 1.2),
    (("u",), "max_speed is 0.8", 1.5),
    (("question_mark",), "type to search", 2.5),
)
MOST = 1_000_000  # bytes
NO_BREAK = "\u00a0"
# of each picture, once is enough, or nobody sees it
_MORE = (
    r"@font-face \{.*?\}",
    r"<!--.*?-->",
    r'<clipPath id="[^"]*-line-[^"]*">.*?</clipPath>',
    r' clip-path="url\(#[^)]*-line-[^)]*\)"',
    r" {2,}",
)


async def frames() -> list[str]:
    """The screen after each step of the story, as SVG."""
    from tests.support.console import console  # not before the engine is chosen

    found = []
    async with console(*ROBOT) as op:
        for keys, seen, _ in STORY:
            for key in keys:
                await op.press(key)
            await op.until(seen)
            found.append(op.app.export_screenshot(simplify=True))
    return found


def joined(pictures: list[str], seconds: list[float]) -> str:
    """One SVG that shows each for so long."""
    whole, begin, styles, shown = sum(seconds), 0.0, [], []
    fonts = re.search(r"@font-face.*?(?=\.terminal)", pictures[0], re.DOTALL)
    box = re.search(r'viewBox="[^"]*"', pictures[0])
    assert fonts is not None
    assert box is not None
    for number, (picture, length) in enumerate(zip(pictures, seconds, strict=True)):
        end = begin + length
        turns = f"0% {{ visibility: hidden }} {100 * begin / whole:.2f}% {{ visibility: visible }}"
        turns += f" {min(100 * end / whole, 99.99):.2f}% {{ visibility: hidden }}"
        styles.append(f"@keyframes s{number} {{ {turns} }}")
        styles.append(f".s{number} {{ animation: s{number} {whole:g}s step-end infinite }}")
        inner = picture.partition(">")[2].rpartition("</svg>")[0]
        for more in _MORE:
            inner = re.sub(more, "", inner, flags=re.DOTALL)
        shown.append(f'<g class="s{number}">{inner.replace("&#160;", NO_BREAK)}</g>')
        begin = end
    sheet = "\n".join(["<style>", fonts[0], *styles, "</style>"])
    head = f'<svg class="rich-terminal" {box[0]} xmlns="http://www.w3.org/2000/svg">'
    return "\n".join([head, sheet, *shown, "</svg>\n"])


def main() -> None:
    """Record, and refuse a file that a page would not load at once."""
    chosen.ENGINE = "embedded"
    with tempfile.TemporaryDirectory() as home:
        os.environ |= {"HOME": home, "XDG_STATE_HOME": home, "XDG_CONFIG_HOME": home}
        os.environ |= {"TERM": "xterm-256color", "COLORTERM": "truecolor"}
        pictures = asyncio.run(frames())
    text = joined(pictures, [seconds for _, _, seconds in STORY])
    size = len(text.encode())
    if size > MOST:
        sys.exit(f"{size} bytes are too many: leave screens out")
    Path(sys.argv[1]).write_text(text, encoding="utf-8")
    print(f"{sys.argv[1]}: {len(pictures)} screens, {size} bytes")


if __name__ == "__main__":
    main()
