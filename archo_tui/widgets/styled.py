"""The styles of the tones of a text, and a key with its word."""

from __future__ import annotations

from collections.abc import Mapping

from rich.cells import cell_len
from rich.style import Style
from textual.color import Color
from textual.content import Content
from textual.style import Style as TextualStyle

from archo_tui.text.state import ACTIVE, BAD, EDGE, OLD, PLAIN, STRONG, WARN, Spans, marked_tone

STYLES = {
    PLAIN: "",
    STRONG: "bold",
    OLD: "$quiet",
    WARN: "bold $warn",
    BAD: "bold $bad",
    ACTIVE: "$primary",
    EDGE: "$edge",
}


# A mark on a bar shows the bar behind it: its colour, or the shade of `░`.
STYLES |= {
    marked_tone(tone): f"{STYLES[tone]} reverse" for tone in (ACTIVE, STRONG, OLD, WARN, BAD)
}
STYLES[marked_tone(EDGE)] = "$foreground on $shade"


def aligned(spans: Spans, width: int) -> Spans:
    """Return spans in one line, the first at the left end, the others at the right; uncut."""
    (left, tone), *numbers = spans
    left, texts = left.rstrip(), [(text.strip(), of) for text, of in numbers]
    room = width - cell_len(left) - sum(cell_len(text) for text, _ in texts)
    gap = 2 if room >= 2 * len(texts) else 1
    blanks = max(room - gap * (len(texts) - 1), 1 if left else 0)
    gaps = [blanks, *[gap] * len(texts)]
    return (left, tone), *((" " * n + text, of) for n, (text, of) in zip(gaps, texts, strict=False))


def content(spans: Spans) -> Content:
    """Return spans as Textual's Content, each with the style of its tone."""
    return Content.assemble(*((text, STYLES[tone]) for text, tone in spans))


def rich_style(tone: str, variables: Mapping[str, str]) -> Style:
    """Return a tone as a Rich style: its colour of the theme, and bold, but no background."""
    words = STYLES[tone].split()
    named = next((variables[word[1:]] for word in words if word.startswith("$")), None)
    colour = None if named is None else Color.parse(named).rich_color
    return Style(color=colour, bold="bold" in words)


def key_content(command: str, key: str, word: str, *, blocked: bool) -> Content:
    """Return a key and its word, as `c charge`; a click runs the command, or says why not."""
    if blocked:
        made = Content.styled(f"{key} {word}", "not bold $off")
    else:
        made = Content.assemble((key, "bold"), f" {word}")
    return made.stylize(click(f"command('{command}')"))


def click(action: str) -> TextualStyle:
    """Return the style of a text that runs an app's action, as `command('stop')`, when clicked."""
    return TextualStyle.from_meta({"@click": f"app.{action}"})
