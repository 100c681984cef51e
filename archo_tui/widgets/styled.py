"""How the tones of a text look."""

from __future__ import annotations

from collections.abc import Mapping

from rich.style import Style
from textual.color import Color
from textual.content import Content

from archo_tui.state_text import ACTIVE, BAD, EDGE, OLD, PLAIN, STRONG, WARN, Spans

STYLES = {
    PLAIN: "",
    STRONG: "bold",
    OLD: "$quiet",
    WARN: "bold $warn",
    BAD: "bold $bad",
    ACTIVE: "$primary",
    EDGE: "$edge",
}


def content(spans: Spans) -> Content:
    """A text of spans as Textual draws it."""
    return Content.assemble(*((text, STYLES[tone]) for text, tone in spans))


def rich_style(tone: str, variables: Mapping[str, str]) -> Style:
    """How a tone looks to Rich, by the variables of the theme."""
    words = STYLES[tone].split()
    named = next((variables[word[1:]] for word in words if word.startswith("$")), None)
    colour = None if named is None else Color.parse(named).rich_color
    return Style(color=colour, bold="bold" in words)
