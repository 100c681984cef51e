"""Dialogs, and whatever else the first picture can do without, are imported behind it."""

from __future__ import annotations

import pkgutil
from importlib import import_module

_PACKAGES = ("archo_tui.commands", "archo_tui.recording", "archo_tui.remote", "archo_tui.screens")


def import_the_rest() -> None:
    """Whatever a key may need: none waits for the disk, or gets a newer program's part."""
    for package in _PACKAGES:
        path = import_module(package).__path__
        for module in pkgutil.iter_modules(path, f"{package}."):
            import_module(module.name)
