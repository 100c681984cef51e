"""A key with its word, as borders, footer and banner show it."""

from __future__ import annotations

from textual.content import Content
from textual.style import Style


def key_content(command: str, key: str, word: str, *, blocked: bool) -> Content:
    """Return a key and its word, as `c charge`; a click runs the command, or says why not."""
    if blocked:
        made = Content.styled(f"{key} {word}", "not bold $off")
    else:
        made = Content.assemble((key, "bold"), f" {word}")
    return made.stylize(click(f"command('{command}')"))


def click(action: str) -> Style:
    """Return the style of a text that runs an app's action, as `command('stop')`, when clicked."""
    return Style.from_meta({"@click": f"app.{action}"})
