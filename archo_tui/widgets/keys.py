"""A key with its word, as borders, footer and banner show it."""

from __future__ import annotations


def key_markup(command: str, key: str, word: str, *, blocked: bool) -> str:
    """Markup that can be clicked: the key is bold while it does something, else all is darker."""
    key, word = (text.replace("[", "\\[") for text in (key, word))  # the key itself may be one
    click = f"@click=app.command('{command}')"
    if blocked:
        return f"[{click}][not bold $off]{key} {word}[/][/]"
    return f"[{click}][bold]{key}[/bold] {word}[/]"
