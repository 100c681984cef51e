"""Questions about the text of a node file, answered by its syntax tree without running it."""

from __future__ import annotations

import ast
from collections.abc import Iterator

_SUPER = "super().__init__('name_of_the_node')"


class Source:
    """The questions about the syntax tree of a file."""

    def __init__(self, text: bytes) -> None:
        self.tree = ast.parse(text)
        self._functions = [
            node
            for node in ast.walk(self.tree)
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        ]

    def has_main_block(self) -> bool:
        """Return True if the file has an `if __name__ == "__main__":`."""
        return any(
            isinstance(node, ast.If) and "__name__" in ast.unparse(node.test)
            for node in self.tree.body
        )

    def line_of_called_callback(self) -> int | None:
        """Return where a callback is called, not given: `create_timer(1.0, self.tick())`."""
        for call in self._calls(self.tree):
            if _name(call).startswith("create_"):
                for given in [*call.args[1:], *(keyword.value for keyword in call.keywords)]:
                    function = given.func if isinstance(given, ast.Call) else None
                    if isinstance(function, ast.Attribute) and _is_self(function.value):
                        return given.lineno
        return None

    def action_server(self) -> tuple[int, bool] | None:
        """Return the line of the file's only ActionServer, and if it may have a cancel_callback."""
        found = [call for call in self._calls(self.tree) if _name(call) == "ActionServer"]
        if len(found) != 1:
            return None
        names = {keyword.arg for keyword in found[0].keywords}  # None stands for `**kwargs`.
        later = any(_name(c) == "register_cancel_callback" for c in self._calls(self.tree))
        return found[0].lineno, later or bool(names & {"cancel_callback", None})

    def line_of_text(self, text: str) -> int | None:
        """Return the first line with a string literal; slashes at its ends do not matter."""
        lines = [
            node.lineno
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            and node.value.strip("/") == text.strip("/")
        ]
        return min(lines, default=None)

    def line_of_call(self, name: str) -> int | None:
        """Return the line of the only call of a function, as `spin` for `rclpy.spin(node)`."""
        lines = [call.lineno for call in self._calls(self.tree) if _name(call) == name]
        return lines[0] if len(lines) == 1 else None

    def missing_super_init(self, name: str) -> tuple[int, str]:
        """Return the line to mend, and why a class does not run the `__init__` of Node."""
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

    def missing_return(self, line: int) -> str:
        """Return the name of what the callback at a line should return and never does."""
        for function in self._functions:
            first = min([function.lineno, *(d.lineno for d in function.decorator_list)])
            if first == line:
                returns = [n for n in ast.walk(function) if isinstance(n, ast.Return) and n.value]
                names = [argument.arg for argument in function.args.args]
                return "" if returns else names[2] if len(names) == 3 else "result"
        return ""

    def _calls(self, *roots: ast.AST) -> Iterator[ast.Call]:
        """Yield every call in parts of the tree."""
        for root in roots:
            for node in ast.walk(root):
                if isinstance(node, ast.Call):
                    yield node


def _name(call: ast.Call) -> str:
    """Return the last name of a called function: `spin` of `rclpy.spin(node)`; else ""."""
    function = call.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _is_self(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id == "self"
