"""How the tones of a text look."""

from __future__ import annotations

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
