"""Lines of text that are redrawn only when they change, and the styles of their tones."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

from rich.cells import cell_len
from rich.style import Style
from textual.content import Content
from textual.geometry import Region
from textual.style import Style as TextualStyle
from textual.widgets import Static

from archo_tui.text.state import (
    ACTIVE,
    BAD,
    EDGE,
    OLD,
    PLAIN,
    STRONG,
    WARN,
    Spans,
    marked_tone,
)

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


class Line(Static):
    """A widget of one line of text, or of several, that is redrawn only when its text changes."""

    _changed: Sequence[Region] = ()  # The lines that are being shown anew; none means all.

    def __init__(self, **options: str) -> None:
        super().__init__("", **options)  # type: ignore[arg-type]
        self._content: Content | None = None
        self._spans: Sequence[Spans] = ()  # What the content was made of.

    @property
    def link_style(self) -> Style:
        """Return no style, so that text that can be clicked looks as it was written."""
        return Style()

    def show_spans(self, *lines: Spans) -> None:
        """Show lines made of spans, of which only those that differ are redrawn."""
        if lines != self._spans:
            pairs = enumerate(zip_longest(self._spans, lines))
            width = self.size.width
            self._changed = [Region(0, y, width, 1) for y, (old, new) in pairs if old != new]
            self.show(Content("\n").join(map(content, lines)))
            self._spans, self._changed = lines, []

    def refresh(self, *regions: Region, **options: bool) -> Any:
        return super().refresh(*(regions or self._changed), **options)

    def show(self, text: Content) -> None:
        """Show a text; an equal one is not drawn again."""
        self._spans = ()
        if self._content is None or not (text is self._content or text.is_same(self._content)):
            self._content = text
            self.update(text, layout=False)
