"""Random faults, planted one by one into a copy of the project: do the tests of their room notice?

    nice python -m tests.mutants [--room ROOM ...] [--sample N] [--seed S] [--root DIR]

Not run with the tests. A seed plants the same faults in the same text. A missed one either lacks a
test or changes nothing that matters: the rate compares, and is no verdict.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import copy
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parent.parent
# Rooms whose folders are rooms, too.
NESTED = ("base", "ros", "screen", "user_code")
# The tests of a room, a folder of archo_tui/, are in the folder of the same name, but for these.
TESTS = {
    "archo_tui": "client test_cli.py",
    "base": "test_clock.py test_collector.py test_project.py test_other_systems.py station",
    "check": "chapter",
    "cli": "test_cli.py test_docs.py client/test_completions.py client/test_shell.py",
    "client": "client assistant",
    "console": "plain client",
    "embedded": "contract embedded",
    "recordings": "black_box replay",
    "ros": "embedded test_docs.py",
    "ros_launch": "launch",
    "screen": "console screens",
    "commands": "commands widgets",
    "session": "nodes test_cli.py user_code station black_box console/test_leaving.py"
    " client/test_beside_a_screen.py",
    "station": "station parameters",
    "text": "verbs widgets",
    "widgets": "widgets screens",
    **dict.fromkeys(("robot", "robot_file"), "robot robots"),
}
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    **{ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt},
    **{ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is},
    **{ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And},
    **{ast.Add: ast.Sub, ast.Sub: ast.Add},
}
LEFT_OUT_FIELDS = ("annotation", "returns", "decorator_list")
LEFT_OUT_BRANCHES = re.compile(r"\b(TYPE_CHECKING|sys\.platform|os\.name|__name__)\b")
LOGGING = re.compile(r"\b(get_logger|logging|_?logger|_?log)\b")
TIMEOUT = 600  # Seconds for the tests of a room; pytest itself ends a test that hangs.


class Mutant(NamedTuple):
    """A place in a text, in bytes, and what stands there instead."""

    line: int
    before: str
    after: str
    start: int
    end: int

    def planted_in(self, text: bytes) -> bytes:
        return text[: self.start] + self.after.encode() + text[self.end :]


def mutants(text: bytes) -> list[Mutant]:
    """Return every fault that the operators make of a module."""
    lines = [0]
    for line in text.split(b"\n"):
        lines.append(lines[-1] + len(line) + 1)
    found = []
    for node, returns in _executed(ast.parse(text), None):
        for place, after in _changes(node, returns):
            start = lines[place.lineno - 1] + place.col_offset
            end = lines[place.end_lineno - 1] + place.end_col_offset
            found.append(Mutant(place.lineno, ast.unparse(place), after, start, end))
    return found


def _executed(node: ast.AST, returns: ast.expr | None) -> Iterator[tuple[ast.AST, ast.expr | None]]:
    """Yield what runs on this system, each with what its function is annotated to return."""
    match node:
        case ast.JoinedStr() | ast.FunctionDef(name="__repr__"):
            return
        case ast.If(test=where) if LEFT_OUT_BRANCHES.search(ast.unparse(where)):
            return
        case ast.Call(func=where) if LOGGING.search(ast.unparse(where)):
            return
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            returns = node.returns
    yield node, returns
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and name not in LEFT_OUT_FIELDS:
                yield from _executed(child, returns)


def _changes(node: ast.AST, returns: ast.expr | None) -> Iterator[tuple[Any, str]]:
    """Yield what the operators replace of a node, and what stands there instead.

    A condition is negated, unless its comparison or its constant changes anyway.
    """
    match node:
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test):
            if not isinstance(test, (ast.Compare, ast.Constant)):
                yield test, f"not ({ast.unparse(test)})"
        case ast.Compare(ops=ops):
            for at, operator in enumerate(ops):
                swapped = [*ops[:at], SWAPS[type(operator)](), *ops[at + 1 :]]
                yield node, f"({_unparsed(node, ops=swapped)})"
        case ast.BoolOp(op=operator):
            yield node, f"({_unparsed(node, op=SWAPS[type(operator)]())})"
        case ast.BinOp(op=(ast.Add() | ast.Sub()) as operator):
            if not (_is_sequence(node.left) or _is_sequence(node.right)):
                yield node, f"({_unparsed(node, op=SWAPS[type(operator)]())})"
        case ast.AugAssign(op=(ast.Add() | ast.Sub()) as operator, value=value):
            if not _is_sequence(value):
                yield node, _unparsed(node, op=SWAPS[type(operator)]())
        case ast.Constant(value=bool(value)):
            yield node, str(not value)
        case ast.Constant(value=int(value) | float(value)):
            yield node, repr(value + 1)
        case ast.Expr(value=ast.Call(func=func) | ast.Await(value=ast.Call(func=func))):
            if not LOGGING.search(ast.unparse(func)):
                yield node, "pass"
        case ast.Return(value=ast.expr() as value) if returns:
            if "None" not in (ast.unparse(returns), ast.unparse(value)):
                yield value, "None"


def _unparsed(node: ast.AST, **changed: object) -> str:
    other = copy.copy(node)
    vars(other).update(changed)
    return ast.unparse(other)


def _is_sequence(node: ast.expr) -> bool:
    """Return True for what cannot be subtracted: whatever runs it would notice."""
    is_text = isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))
    return is_text or isinstance(node, (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp))


def rooms(root: Path) -> dict[str, list[Path]]:
    """Return the files of each room, below the root."""
    found: dict[str, list[Path]] = {}
    for path in sorted([*root.glob("archo_tui/**/*.py"), *root.glob("nodes/**/*.py")]):
        file = path.relative_to(root)
        folders = file.parts[: -1 if file.parts[0] == "archo_tui" else 1]
        place = 2 if folders[1:2] and folders[1] in NESTED else 1
        found.setdefault(folders[: place + 1][-1], []).append(file)
    return found


def tests_of(room: str) -> list[str]:
    """Return the files and folders of a room's tests, below the root."""
    return [f"tests/{name}" for name in TESTS.get(room, room).split()]


def sample(root: Path, room: str, count: int, seed: int) -> list[tuple[Path, Mutant]]:
    """Draw faults of a room, each as likely as any other."""
    drawn = [(f, mutant) for f in rooms(root)[room] for mutant in mutants((root / f).read_bytes())]
    return random.Random(f"{seed} {room}").sample(drawn, min(count, len(drawn)))


def noticed_by(folder: Path, tests: list[str]) -> str:
    """Return the first test that fails, again when it runs alone; empty when none does."""
    while "::" in (test := _first_failure(folder, tests)) and not _first_failure(folder, [test]):
        tests = [*tests, f"--deselect={test}"]  # It failed by chance, on a busy machine.
    return test


def _first_failure(folder: Path, tests: list[str]) -> str:
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    words += ["-p", "no:randomly", "-o", "faulthandler_timeout=60"]
    home = str(folder.parent)
    environ = os.environ | {"PYTHONPATH": f"{folder}:{folder / 'nodes'}"}
    environ |= {"HOME": home, "PYTEST_DEBUG_TEMPROOT": home}
    with subprocess.Popen(
        [*words, *tests],
        cwd=folder,
        env=environ,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            output = process.communicate(timeout=TIMEOUT)[0]
        except subprocess.TimeoutExpired:
            return "it hangs"
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            _kill_all_at(home)
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", output, re.MULTILINE)
    return "" if process.returncode == 0 else failed[1] if failed else "pytest does not run"


def _kill_all_at(home: str) -> None:
    """Kill whatever the tests began: a fault may let a process in a session of its own spin."""
    for environ in Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):  # It has ended, or is another user's.
            if f"HOME={home}".encode() in environ.read_bytes().split(b"\0"):
                os.kill(int(environ.parent.name), signal.SIGKILL)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--room", action="append", help="plant faults in this one only")
    parser.add_argument("--sample", type=int, default=3, help="how many faults a room")
    parser.add_argument("--seed", type=int, default=1, help="another one draws other faults")
    parser.add_argument("--root", type=Path, default=ROOT, help="a checkout to be tried instead")
    options = parser.parse_args()
    passed: list[list[str]] = []
    rates: dict[str, tuple[int, int]] = {}
    print(f"seed {options.seed}, {options.sample} a room", flush=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "copy"
        ignored = shutil.ignore_patterns(".venv", ".git", "*.egg-info", "__pycache__")
        shutil.copytree(options.root, folder, ignore=ignored, symlinks=True)
        for room in options.room or rooms(folder):
            tests = tests_of(room)
            if tests not in passed and (failed := noticed_by(folder, tests)):
                print(f"{room}: left out, {failed} fails without a fault", flush=True)
                continue
            passed.append(tests)
            drawn = sample(folder, room, options.sample, options.seed)
            caught = 0
            for file, mutant in drawn:
                text = (folder / file).read_bytes()
                (folder / file).write_bytes(mutant.planted_in(text))
                test = noticed_by(folder, tests)
                (folder / file).write_bytes(text)
                caught += bool(test)
                result = f"caught by {test}\n   " if test else "MISSED"
                change = f"{mutant.before[:70]} -> {mutant.after[:70]}"
                print(f"{result} {file}:{mutant.line}: {change}", flush=True)
            rates[room] = caught, len(drawn)
    rates["all"] = sum(caught for caught, _ in rates.values()), sum(n for _, n in rates.values())
    for room, (caught, count) in rates.items():
        print(f"{room:12} {caught:3} of {count:3} {caught / max(count, 1):5.0%}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
