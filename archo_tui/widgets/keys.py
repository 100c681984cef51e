"""A key with its word, as borders, footer and banner show it."""

from __future__ import annotations

from textual.content import Content
from textual.style import Style


def key_content(command: str, key: str, word: str, *, blocked: bool) -> Content:
    """Return a key and its word, which can be clicked.

    Args:
        command: The id of the command.
        key: The key, as a person reads it.
        word: The word.
        blocked: True if the command cannot run now: all of it is darker.
    """
    if blocked:
        made = Content.styled(f"{key} {word}", "not bold $off")
    else:
        made = Content.assemble((key, "bold"), f" {word}")
    return made.stylize(click(f"command('{command}')"))


def click(action: str) -> Style:
    """Return the style of a text that runs one of the app's actions when it is clicked."""
    return Style.from_meta({"@click": f"app.{action}"})
