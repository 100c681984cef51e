"""How the tones of a text look."""

from __future__ import annotations

from textual.content import Content

from archo_tui.goal_text import ACTIVE
from archo_tui.state_text import BAD, OLD, PLAIN, STRONG, WARN, Spans

STYLES = {
    PLAIN: "",
    STRONG: "bold",
    OLD: "dim",
    WARN: "bold $text-warning",
    BAD: "bold $text-error",
    ACTIVE: "$primary",
}


def content(spans: Spans) -> Content:
    """A text of spans as Textual draws it."""
    return Content.assemble(*((text, STYLES[tone]) for text, tone in spans))
