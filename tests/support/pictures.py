"""Pictures of the screen beside those that were accepted."""

from __future__ import annotations

from functools import partialmethod
from pathlib import Path

import pytest
from rich.console import Console

FOLDER = Path(__file__).parent.parent / "snapshots"


def steady(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing of this machine is in a picture."""
    monkeypatch.chdir("/")  # a dialog names the folder
    monkeypatch.setenv("COLORTERM", "truecolor")
    # else the ids in a picture are made of all that is in it
    export_svg = partialmethod(Console.export_svg, unique_id="terminal")
    monkeypatch.setattr(Console, "export_svg", export_svg)


def differs(request: pytest.FixtureRequest, name: str, actual: str) -> list[str]:
    """What to say when the picture differs from the accepted one; the new one is left beside it."""
    path = FOLDER / f"{name.replace(' ', '_')}.svg"
    new = path.with_suffix(".new.svg")
    if request.config.getoption("--update-snapshots"):
        path.write_text(actual)
    if path.is_file() and path.read_text() == actual:
        new.unlink(missing_ok=True)
        return []
    new.write_text(actual)
    return [f"{path.name} differs: look at {new}, accept it with --update-snapshots"]
