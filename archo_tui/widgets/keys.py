"""A key with its word, as borders, footer and banner show it."""

from __future__ import annotations

from textual.content import Content
from textual.style import Style


def key_content(command: str, key: str, word: str, *, blocked: bool) -> Content:
    """It can be clicked: the key is bold while it does something, else all is darker."""
    if blocked:
        made = Content.styled(f"{key} {word}", "not bold $off")
    else:
        made = Content.assemble((key, "bold"), f" {word}")
    return made.stylize(click(f"command('{command}')"))


def click(action: str) -> Style:
    """Of a text that does something when it is clicked: `action` is one of the app's."""
    return Style.from_meta({"@click": f"app.{action}"})
