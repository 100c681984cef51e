"""Lines of text, of which only what changes is redrawn, and the styles of their tones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.cells import cell_len
from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.content import Content
from textual.geometry import Region
from textual.strip import Strip
from textual.style import Style as TextualStyle
from textual.widget import Widget
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
    not_drawn,
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


class LineWidget(Widget):
    """The base of widgets that draw their lines in a `render_line` of their own.

    List it last among the bases: Textual looks for styles by the names of the first ones.
    """

    base = Style()  # Of a blank cell, set before lines are rendered.

    def render_lines(self, crop: Region) -> list[Strip]:
        self.base = self.rich_style  # Computed once: it depends on all ancestors.
        try:
            return super().render_lines(crop)
        except Exception as error:  # The other widgets go on.
            line = Strip([Segment(not_drawn(error), self.base)]).crop_extend(
                *crop.column_span, self.base
            )
            return [line] * crop.height


class TextLines(LineWidget):
    """A widget with rows of text, such as a plot, of which only those that changed are redrawn."""

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._lines: Sequence[Spans] = ()

    def show(self, lines: Sequence[Spans]) -> None:
        """Show these lines in place of those before; the rows that differ are redrawn."""
        before, self._lines = self._lines, lines
        for y in range(max(len(before), len(lines))):
            if list(before[y : y + 1]) != list(lines[y : y + 1]):
                self.refresh(Region(0, y, self.size.width, 1))

    def render_line(self, y: int) -> Strip:
        base, variables = self.base, self.app.theme_variables
        line = self._lines[y] if y < len(self._lines) else ()
        segments = [Segment(text, base + rich_style(tone, variables)) for text, tone in line]
        return Strip(segments).crop_extend(0, self.size.width, base)


class Line(Static):
    """A widget of one line of text that is redrawn only when its text changes."""

    def __init__(self, **options: str) -> None:
        super().__init__("", **options)  # type: ignore[arg-type]
        self._content: Content | None = None
        self._spans: Spans | None = None  # What the content was made of.

    @property
    def link_style(self) -> Style:
        """Return no style, so that text that can be clicked looks as it was written."""
        return Style()

    def show_spans(self, spans: Spans) -> None:
        """Show a text made of spans; equal spans change nothing."""
        if spans != self._spans:
            self.show(content(spans))
            self._spans = spans

    def show(self, text: Content) -> None:
        """Show a text; an equal one is not drawn again."""
        self._spans = None
        if self._content is None or not (text is self._content or text.is_same(self._content)):
            self._content = text
            self.update(text, layout=False)
