"""A key with its word, as borders, footer and banner show it."""

from __future__ import annotations

from textual.content import Content
from textual.style import Style


def key_content(command: str, key: str, word: str, *, blocked: bool) -> Content:
    """Return a key and its word, as `c charge`; a click on them runs the command, or says why not.

    Args:
        command: The id of the command.
        key: The key, as a person reads it.
        word: The word.
        blocked: True if the command cannot run now; key and word are darker then.
    """
    if blocked:
        made = Content.styled(f"{key} {word}", "not bold $off")
    else:
        made = Content.assemble((key, "bold"), f" {word}")
    return made.stylize(click(f"command('{command}')"))


def click(action: str) -> Style:
    """Return the style of a text that runs an action of the app when it is clicked.

    Args:
        action: The action with its arguments, as `command('stop')`.
    """
    return Style.from_meta({"@click": f"app.{action}"})
