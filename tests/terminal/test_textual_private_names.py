"""The names that Textual does not promise and that the console needs: each is still there.

Textual is pinned to its minor version because of them. They are found in the console's source: a
private name that it takes from Textual's modules or of Textual's objects, or defines or uses in a
class that inherits from one of Textual's with the same name, on purpose or by accident.
"""

from __future__ import annotations

import importlib
import inspect
import re
from functools import cache
from pathlib import Path

import textual

ROOT = Path(__file__).parent.parent.parent
TEXTUAL = Path(textual.__file__).parent
# The others import nothing of it, as .ci/lint checks.
SCREEN = ROOT / "archo_tui" / "screen"
MODULES = sorted(str(path.relative_to(ROOT)) for path in SCREEN.rglob("*.py"))
# what is found, by file: a new use belongs here, and what is no longer found has changed its name
KNOWN = {
    "app.py": "_handle_exception",
    "keyed_app.py": "_bindings _check_bindings",
    "base.py": "_compositor_refresh _repaint_required",
    "dialog.py": "_bindings",
    "main.py": "_compositor_refresh",
    "terminal/app.py": "_context _handle_exception _skip _styles_cache",
    "terminal/driver.py": "_writer_thread",
    "terminal/keyboard.py": "_xterm_parser",
    "terminal/stop_marks.py": "_prevent",
    "widgets/field.py": "_forward_event",
    "widgets/rows.py": "_refresh_scrollbars",
}


_DEFINED = re.compile(
    r"(?:\b(?:self\.|def |class )|^ *)(_[a-z]\w*[a-z])(?=\(| ?[:=,])", re.MULTILINE
)


@cache
def names_in(file: Path) -> set[str]:
    return {*_DEFINED.findall(file.read_text(encoding="utf-8"))}


def defined_in(*files: Path) -> set[str]:
    """The private names that sources define: functions, classes, attributes."""
    return set().union(*map(names_in, files))


@cache
def foreign_names() -> set[str]:
    """Those that Textual defines and the console does not."""
    return defined_in(*TEXTUAL.rglob("*.py")) - defined_in(*SCREEN.rglob("*.py"))


def shared_names(kind: type) -> set[str]:
    """Those that a class has in common with what it inherits from Textual."""
    used = re.findall(r"\b(?:self\.|cls\.|def )(_\w+)", inspect.getsource(kind))
    bases = [base for base in kind.__mro__ if base.__module__.startswith("textual")]
    return {*used} & defined_in(*(Path(inspect.getfile(base)) for base in bases))


def found_in(module: str) -> str:
    text = (ROOT / module).read_text(encoding="utf-8")
    loaded = importlib.import_module(module.removesuffix(".py").replace("/", "."))
    found = {*re.findall(r"(?<!self)(?<!cls)\.(_[a-z]\w*)", text)} & foreign_names()
    found |= {*re.findall(r"^from textual[\w.]*\.(_\w+) import", text, re.MULTILINE)}
    for names in re.findall(r"^from textual\S* import (.*)", text, re.MULTILINE):
        found |= {*re.findall(r"\b_\w+", names)}
    for kind in vars(loaded).values():
        if isinstance(kind, type) and kind.__module__ == loaded.__name__:
            found |= shared_names(kind)
    return " ".join(sorted(found - {"_replace"}))  # `_replace` is a named tuple's.


def test_its_private_names_that_the_console_uses_are_these_and_still_there() -> None:
    found = {module.removeprefix("archo_tui/screen/"): found_in(module) for module in MODULES}
    assert {module: names for module, names in found.items() if names} == KNOWN
