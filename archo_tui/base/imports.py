"""The import of everything that the first picture can do without, after that picture."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable
from importlib import import_module

OF_ALL = ("archo_tui.recordings", "archo_tui.console")  # Needed with and without a screen.
OF_THE_SCREEN = ("archo_tui.screen.commands", "archo_tui.screen", "archo_tui.recordings.replay")


def import_the_rest(packages: Iterable[str]) -> None:
    """Import packages with all their modules, but not those of their subpackages.

    Later on no key waits for the disk, or gets a part of a newer version of the program.
    """
    for package in packages:
        path = import_module(package).__path__
        for module in pkgutil.iter_modules(path, f"{package}."):
            import_module(module.name)
