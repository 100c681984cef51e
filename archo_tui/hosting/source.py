"""What the text of a node file says, by its syntax tree: it is never run for that."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

MULTI_THREADED = "MultiThreadedExecutor"
_EXECUTORS = ("SingleThreadedExecutor", MULTI_THREADED)
_SUPER = "super().__init__('name_of_the_node')"
_SPINS = ("init", "spin", "spin_once", "spin_until_future_complete")


class Source:
    """A file's syntax tree, and the questions about it."""

    def __init__(self, text: bytes) -> None:
        """Raises SyntaxError."""
        self.tree = ast.parse(text)
        self._functions = [
            node
            for node in ast.walk(self.tree)
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        ]

    def threads(self) -> int | None:
        """How many threads `main()` spins with, 0 for as many as rclpy likes; None for one.

        What stands below `if __name__ == "__main__"` counts as `main()`, and so does what it calls.
        """
        roots = [*self._main()]
        for call in self._calls(*roots):
            if self._is_of_rclpy(call.func, MULTI_THREADED):
                given = [*call.args[:1], *(k.value for k in call.keywords if k.arg)]
                numbers = [n.value for n in given if isinstance(n, ast.Constant)]
                number = next((n for n in numbers if isinstance(n, int)), 0)
                return None if number == 1 else number
        return 0 if self._is_named(roots, MULTI_THREADED) else None

    def has_executor(self) -> bool:
        """Return whether `main()`, or what it calls, makes an executor of its own."""
        roots = [*self._main()]
        return any(self._is_named(roots, name) for name in _EXECUTORS)

    def _is_named(self, roots: Iterable[ast.AST], name: str) -> bool:
        return any(self._is_of_rclpy(node, name) for root in roots for node in ast.walk(root))

    def _is_of_rclpy(self, node: ast.AST, name: str) -> bool:
        """Return whether a node names that class, by what it was imported as, too."""
        others = {
            alias.asname
            for imported in ast.walk(self.tree)
            if isinstance(imported, ast.ImportFrom)
            for alias in imported.names
            if alias.name == name
        }
        if isinstance(node, ast.Attribute):
            return node.attr == name
        return isinstance(node, ast.Name) and node.id in {name, *others}

    def runs_at_import(self) -> tuple[str, int] | None:
        """The name and line of a function that spins and is called when the file is imported."""
        rclpys = {*self._of_rclpy()}
        spinning = {
            function.name
            for function in self._functions
            if any(_name(call) in _SPINS for call in self._calls(function))
            and any(isinstance(n, ast.Name) and n.id in rclpys for n in ast.walk(function))
        }
        defined = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.If)
        run = [node for node in self.tree.body if not isinstance(node, defined)]
        for call in self._calls(*run):
            if isinstance(call.func, ast.Name) and call.func.id in spinning:
                return call.func.id, call.lineno
        return None

    def called_too_early(self) -> int | None:
        """The line where a callback is not given but called: `create_timer(1.0, self.tick())`."""
        for call in self._calls(self.tree):
            if _name(call).startswith("create_"):
                for given in [*call.args[1:], *(keyword.value for keyword in call.keywords)]:
                    function = given.func if isinstance(given, ast.Call) else None
                    if isinstance(function, ast.Attribute) and _is_self(function.value):
                        return given.lineno
        return None

    def action_server(self) -> tuple[int, bool] | None:
        """The line of the only ActionServer, and whether it is given a cancel_callback."""
        found = [call for call in self._calls(self.tree) if _name(call) == "ActionServer"]
        if len(found) != 1:
            return None
        names = {keyword.arg for keyword in found[0].keywords}  # None: all of a dict
        later = any(_name(c) == "register_cancel_callback" for c in self._calls(self.tree))
        return found[0].lineno, later or bool(names & {"cancel_callback", None})

    def line_of_text(self, text: str) -> int | None:
        """The first line with that string, or with that name of a topic."""
        lines = [
            node.lineno
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and node.value.strip("/") == text.strip("/")
        ]
        return min(lines, default=None)

    def line_of_call(self, name: str) -> int | None:
        """Where a function is called, when that is one place only."""
        lines = [call.lineno for call in self._calls(self.tree) if _name(call) == name]
        return lines[0] if len(lines) == 1 else None

    def unmade(self, name: str) -> tuple[int, str]:
        """Line and words for a class whose `__init__` does not call that of Node."""
        classes = [node for node in ast.walk(self.tree) if isinstance(node, ast.ClassDef)]
        kind = next((node for node in classes if node.name == name), None)
        if kind is None:
            return 1, f"{name} does not call {_SUPER}"
        inits = [n for n in kind.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"]
        if not inits:
            return kind.lineno, f"{name} has no __init__ that calls {_SUPER}"
        if any(_name(call) == "__init__" for call in self._calls(*inits)):
            return inits[0].lineno, f"{_SUPER} must be the first line of __init__"
        return inits[0].lineno, f"__init__ does not call {_SUPER}, so there is no node"

    def gives_nothing(self, line: int) -> str:
        """What the function that begins at a line should return, and never does; "" otherwise."""
        for function in self._functions:
            first = min([function.lineno, *(d.lineno for d in function.decorator_list)])
            if first == line:
                returns = [n for n in ast.walk(function) if isinstance(n, ast.Return) and n.value]
                names = [argument.arg for argument in function.args.args]
                return "" if returns else names[2] if len(names) == 3 else "result"
        return ""

    def _main(self) -> Iterator[ast.AST]:
        """`main()`, what stands below an `if`, and the file's functions that these call."""
        functions = {n.name: n for n in self.tree.body if isinstance(n, ast.FunctionDef)}
        roots: list[ast.AST] = [n for n in self.tree.body if isinstance(n, ast.If)]
        roots += [function for name, function in functions.items() if name == "main"]
        for root in roots:
            yield root
            for call in self._calls(root):
                called = functions.get(call.func.id) if isinstance(call.func, ast.Name) else None
                if called is not None and called not in roots:
                    roots.append(called)

    def _of_rclpy(self) -> Iterator[str]:
        """What rclpy, and what is imported from it, is called here."""
        for node in ast.walk(self.tree):
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                module = node.module if isinstance(node, ast.ImportFrom) else ""
                for alias in node.names:
                    if (module or alias.name).partition(".")[0] == "rclpy":
                        yield alias.asname or alias.name.partition(".")[0]

    def _calls(self, *roots: ast.AST) -> Iterator[ast.Call]:
        for root in roots:
            for node in ast.walk(root):
                if isinstance(node, ast.Call):
                    yield node


def _name(call: ast.Call) -> str:
    """What is called: `spin` of `rclpy.spin(node)`."""
    function = call.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _is_self(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id == "self"
