"""Themes of our own, beside Textual's, and the one that the operator chose last."""

from __future__ import annotations

from pathlib import Path

from textual.theme import BUILTIN_THEMES, Theme

from archo_tui.paths import config_file, make_folder

HIGH_CONTRAST = Theme(
    name="high-contrast",
    primary="#ffff00",
    secondary="#00ffff",
    accent="#ffff00",
    foreground="#ffffff",
    background="#000000",
    surface="#000000",
    panel="#1c1c1c",
    success="#00ff00",
    warning="#ffff00",
    error="#ff8080",
    dark=True,
    variables={
        "text-error": "#ff8080",
        "text-warning": "#ffff00",
        "text-muted": "#ffffff",
        "text-disabled": "#d0d0d0",
    },
)
THEMES = (HIGH_CONTRAST,)


def remembered() -> str:
    """The name of the theme that was chosen last, or an empty string."""
    try:
        name = _file().read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        return ""
    known = {*BUILTIN_THEMES, *(theme.name for theme in THEMES)}
    return name if name in known else ""


def remember(name: str) -> None:
    """Choose it the next time. Raises OSError."""
    make_folder(_file())
    _file().write_text(f"{name}\n", encoding="utf-8")


def _file() -> Path:
    return config_file("theme")
