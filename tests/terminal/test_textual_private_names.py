"""The names that Textual does not promise and that the console needs: each is still there.

Textual is pinned to its minor version because of them. They are found in the console's source: a
private name that it takes from Textual's modules or of Textual's objects, or defines or uses in a
class that inherits from one of Textual's with the same name, on purpose or by accident.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from collections.abc import Iterator
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
    "terminal/app.py": "_context _handle_exception _styles_cache",
    "terminal/driver.py": "_writer_thread",
    "terminal/keyboard.py": "_xterm_parser",
    "terminal/stop_marks.py": "_prevent",
    "widgets/field.py": "_forward_event",
    "widgets/rows.py": "_refresh_scrollbars",
}


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("_") and name not in ("_replace", "_asdict")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(tree: ast.AST) -> tuple[ast.AST, ...]:
    """All nodes of a source, which is looked through several times."""
    return tuple(ast.walk(tree))


def defined_in(tree: ast.AST) -> set[str]:
    """The private names that a source defines: functions, classes, attributes; no local ones."""
    found = set()
    for node in nodes_of(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            found.add(node.attr)
        if isinstance(node, (ast.ClassDef, ast.Module)):
            lines = [line for line in node.body if isinstance(line, (ast.Assign, ast.AnnAssign))]
            names = [name for line in lines for name in ast.walk(line)]
            found |= {name.id for name in names if isinstance(name, ast.Name)}
    return {name for name in found if is_private(name)}


@cache
def own_names() -> set[str]:
    return set().union(*(defined_in(tree_of(ROOT / module)) for module in MODULES))


@cache
def textuals_names(file: str) -> set[str]:
    return defined_in(tree_of(Path(file)))


@cache
def all_of_textuals_names() -> set[str]:
    texts = [path.read_text(encoding="utf-8") for path in TEXTUAL.rglob("*.py")]
    return set(re.findall(r"\b(?:self\.|def |class )(_\w+)", "".join(texts)))


def inherited(kind: type) -> set[str]:
    """The private names of what a class inherits from Textual."""
    files = {inspect.getsourcefile(b) for b in kind.__mro__ if b.__module__.startswith("textual")}
    return set().union(*(textuals_names(file) for file in files if file))


def imported(tree: ast.Module) -> Iterator[str]:
    """Private modules of Textual, and private names of its modules."""
    for node in nodes_of(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("textual"):
            module = (node.module or "").rpartition(".")[2]
            yield from [module] if is_private(module) else []
            yield from (alias.name for alias in node.names if is_private(alias.name))


def of_others(tree: ast.Module) -> Iterator[str]:
    """Private attributes of objects that are not the class's own."""
    theirs = all_of_textuals_names() - own_names()
    for node in nodes_of(tree):
        if isinstance(node, ast.Attribute) and node.attr in theirs and is_private(node.attr):
            itself = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            if not itself:
                yield node.attr


def shared(module: str, tree: ast.Module) -> Iterator[str]:
    """Private names that a class has in common with what it inherits from Textual."""
    loaded = importlib.import_module(module.removesuffix(".py").replace("/", "."))
    for node in tree.body:
        kind = getattr(loaded, node.name, None) if isinstance(node, ast.ClassDef) else None
        if isinstance(kind, type):
            used = {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)}
            yield from (used | defined_in(node)) & inherited(kind)


def found_in(module: str) -> str:
    tree = tree_of(ROOT / module)
    names = {*imported(tree), *of_others(tree)}
    if any(isinstance(node, ast.ClassDef) for node in tree.body):
        names |= set(shared(module, tree))
    return " ".join(sorted(name for name in names if is_private(name)))


def test_its_private_names_that_the_console_uses_are_these_and_still_there() -> None:
    found = {module.removeprefix("archo_tui/screen/"): found_in(module) for module in MODULES}
    assert {module: names for module, names in found.items() if names} == KNOWN
