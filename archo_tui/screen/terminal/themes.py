"""The console's own themes, and the theme that the operator chose last."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from textual.color import Color
from textual.theme import BUILTIN_THEMES, Theme

from archo_tui.base.paths import config_file, make_folder
from archo_tui.base.regular_files import read, replace

HIGH_CONTRAST = Theme(
    name="high-contrast",
    primary="#00ffff",  # of what is normal and of the focus: another than a warning's
    secondary="#00ffff",
    accent="#00ffff",
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
        "quiet": "#d0d0d0",
        "off": "#a0a0a0",
        "edge": "#ffffff",
    },
)
THEMES = (HIGH_CONTRAST,)
# The tones among 16 colours, which have two greys: brighter for labels, darker for borders.
TONES_OF_16_COLOURS = {"quiet": "#aaaaaa", "off": "#555555", "edge": "#555555", "shade": "#555555"}

_STOPPED = "#af0000"  # red with 256 colours and with 16, too, where a theme's may turn magenta
_SHADE = 0.3  # The share of the colour in `░`.

# The colour to begin with, and the least contrast to every background: WCAG asks for 4.5 and 3.
_TONES = {
    "quiet": ("background", 4.6),
    "off": ("background", 3.1),
    "edge": ("background", 2.0),
    "warn": ("text-warning", 4.6),
    "bad": ("text-error", 4.6),
    "held": ("stopped", 4.6),
}


def derive_tones(variables: Mapping[str, str]) -> dict[str, str]:
    """Return tones between a theme's colours and its foreground, as faint as can be read.

    They are `quiet` for labels, keys and old values, `off` for what cannot be done, `edge` for
    borders, `warn` and `bad` for what is abnormal, `stopped` for STOP, `held` for STOP while the
    robot is stopped, `shade` for the empty part of a bar.
    """
    front = Color.parse(variables["foreground"])
    behind = [Color.parse(variables[name]) for name in ("background", "surface", "panel")]
    found = {}
    known = {**variables, "stopped": _STOPPED}
    for name, (begin, least) in _TONES.items():
        first = Color.parse(known[begin])
        steps = (first.blend(front, step / 50) for step in range(51))
        readable = (c for c in steps if min(contrast(c, back) for back in behind) >= least)
        found[name] = next(readable, front).hex
    edge = Color.parse(variables.get("edge", found["edge"]))
    return {**found, "stopped": _STOPPED, "shade": behind[0].blend(edge, _SHADE).hex}


def to_grey(variables: Mapping[str, str]) -> dict[str, str]:
    """Return the colours of backgrounds and scroll bars as greys; leave all other colours out.

    The dark colours among 256 are blue or black.
    """
    names = ("background", "surface", "panel", "scrollbar-background", "scrollbar-corner")
    found = {}
    for name, value in variables.items():
        if name.startswith(names) and value.startswith("#"):
            found[name] = Color.parse(value).monochrome.hex
    return found


def contrast(one: Color, other: Color) -> float:
    """Return the contrast ratio of two colours, 1 to 21, by WCAG 2.1."""
    darker, lighter = sorted((_luminance(one), _luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


@lru_cache  # Hundreds of colours are compared with the same few.
def _luminance(colour: Color) -> float:
    parts = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in colour.normalized
    )
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), parts, strict=True))


def remembered_theme() -> str:
    """Return the name of the theme that was chosen last; "" if there is none or it is unknown."""
    try:
        name = read(_file()).decode().strip()
    except (OSError, UnicodeDecodeError):
        return ""
    known = {*BUILTIN_THEMES, *(theme.name for theme in THEMES)}
    return name if name in known else ""


def remember_theme(name: str) -> None:
    """Write the name of a theme, unchecked, for the next start; raise OSError."""
    make_folder(_file())
    replace(_file(), f"{name}\n")


def _file() -> Path:
    return config_file("theme")
