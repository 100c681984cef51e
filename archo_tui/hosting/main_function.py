"""What `main()` of a node file makes and calls, by its syntax tree: it is never run."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import rclpy
from rclpy.node import Node

_LONGEST = 60  # characters of a call that are quoted
# What is done here in another way, or changes nothing that a node does.
_SETTLED = {
    *("init", "ok", "shutdown", "try_shutdown", "destroy_node", "add_node", "remove_node"),
    *("spin", "spin_once", "spin_until_future_complete", "get_logger", "get_name", "print"),
    *("append", "extend", "list", "isinstance"),
}


class ComputedError(Exception):
    """An argument of a node that only `main()` could tell."""

    def __init__(self, call: ast.Call) -> None:
        super().__init__(quoted(call))
        self.line = call.lineno


class Made(NamedTuple):
    """One node as `main()` makes it."""

    kind: type[Node]
    args: tuple[Any, ...]
    keywords: dict[str, Any]
    line: int  # of the call; 0: `main()` has none
    text: str  # the call, as it is quoted; "" without one


class NotRun(NamedTuple):
    """A call in `main()` that concerns a node and is not done by hosting the node."""

    line: int
    function: str  # that calls it; "" below `if __name__ == "__main__"`
    text: str


class MainFunction(ast.NodeVisitor):
    """Follows `main()` and the file's functions that it calls, in the order of execution."""

    def __init__(self, tree: ast.Module, names: Mapping[str, Any]) -> None:
        """Follow it.

        Args:
            tree: The file's syntax tree.
            names: What the file's module holds, by name.

        Raises:
            ComputedError: A node is given what only `main()` could tell.
        """
        self.made: list[Made] = []
        self.not_run: list[NotRun] = []
        self._names = names
        self._functions = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
        self._within: list[str] = []  # names of the functions that are being followed
        self._nodes: set[str] = set()  # local names of nodes
        self._values: dict[str, Any] = {}  # local names of what was given by value
        self._spins = False  # what comes later is done at the end, if ever
        self._follow_all(tree)

    def _follow_all(self, tree: ast.Module) -> None:
        ifs = [node for node in tree.body if isinstance(node, ast.If)]
        for statement in ifs:
            self.visit(statement)
        if not self.made and "main" in self._functions:
            self._spins = False
            self._follow(self._functions["main"], ())

    def _follow(self, function: ast.FunctionDef, given: Sequence[ast.expr]) -> None:
        """Follow a function of the file, given the arguments by position."""
        values, nodes = self._values, self._nodes
        names = [argument.arg for argument in function.args.args]
        defaults = function.args.defaults
        bound = [*zip(names[len(names) - len(defaults) :], defaults, strict=True)]
        self._values, self._nodes = {}, set()
        for name, default in bound:
            self._bind_value(name, default, {})
        for name, argument in zip(names, given, strict=False):
            self._values.pop(name, None)
            self._bind_value(name, argument, values)
            if isinstance(argument, ast.Name) and argument.id in nodes:
                self._nodes.add(name)
        self._within.append(function.name)
        for statement in function.body:
            self.visit(statement)
        self._within.pop()
        self._values, self._nodes = values, nodes

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        """Skip what is defined and not called."""

    visit_AsyncFunctionDef = visit_ClassDef = visit_Lambda = visit_FunctionDef  # type: ignore

    def visit_Try(self, node: ast.Try) -> None:
        """Skip what is done when something fails, and at the end."""
        for statement in [*node.body, *node.orelse]:
            self.visit(statement)

    def visit_Assign(self, node: ast.Assign) -> None:
        """Remember which names are nodes and which are values."""
        count = len(self.made)
        self.visit(node.value)
        for target in node.targets:
            if isinstance(target, ast.Name):
                self._bind(target.id, node.value, len(self.made) > count)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Treat it as a plain assignment."""
        if node.value is not None:
            self.visit_Assign(ast.Assign([node.target], node.value))

    def visit_With(self, node: ast.With) -> None:
        """Treat `with Talker() as talker` as an assignment."""
        for item in node.items:
            targets = [] if item.optional_vars is None else [item.optional_vars]
            self.visit_Assign(ast.Assign(targets, item.context_expr))
        for statement in node.body:
            self.visit(statement)

    def visit_Call(self, node: ast.Call) -> None:
        """Judge a call, behind what its arguments call."""
        self.generic_visit(node)
        function = node.func
        own = self._functions.get(function.id) if isinstance(function, ast.Name) else None
        kind = self._kind(function)
        if own is not None:
            if own.name not in self._within:
                self._follow(own, node.args)
        elif kind is not None:
            self._make(kind, node)
        elif not self._spins and self._concerns_node(node):
            within = self._within[-1] if self._within else ""
            self.not_run.append(NotRun(node.lineno, within, quoted(node)))
        if isinstance(function, (ast.Attribute, ast.Name)):
            name = function.attr if isinstance(function, ast.Attribute) else function.id
            self._spins |= name == "spin"

    def _kind(self, function: ast.expr) -> type[Node] | None:
        """Return the class of the node that a call of this makes; None when it makes none."""
        found = self._resolved(function)
        if found is rclpy.create_node:
            return Node
        return found if isinstance(found, type) and issubclass(found, Node) else None

    def _resolved(self, expression: ast.expr) -> Any:
        if isinstance(expression, ast.Name):
            return self._names.get(expression.id)
        if isinstance(expression, ast.Attribute):
            return getattr(self._resolved(expression.value), expression.attr, None)
        return None

    def _make(self, kind: type[Node], call: ast.Call) -> None:
        given = {word.arg: word.value for word in call.keywords if word.arg != "context"}
        try:
            args = tuple(self._value(argument, self._values) for argument in call.args)
            keywords = {
                name or "": self._value(value, self._values) for name, value in given.items()
            }
        except ValueError:
            raise ComputedError(call) from None
        made = Made(kind, args, keywords, call.lineno, quoted(call))
        if not any(made[:3] == other[:3] for other in self.made):  # of an if and its else
            self.made.append(made)

    def _bind(self, name: str, value: ast.expr, is_made: bool) -> None:
        self._values.pop(name, None)
        self._nodes.discard(name)
        if is_made or (isinstance(value, ast.Name) and value.id in self._nodes):
            self._nodes.add(name)
        else:
            self._bind_value(name, value, self._values)

    def _bind_value(self, name: str, value: ast.expr, values: Mapping[str, Any]) -> None:
        try:
            self._values[name] = self._value(value, values)
        except ValueError:
            return

    def _value(self, expression: ast.expr, values: Mapping[str, Any]) -> Any:
        """Return a value that stands in the file. Raises ValueError for any other."""
        if isinstance(expression, ast.Name):
            for known in (values, self._names):
                if expression.id in known:
                    return known[expression.id]
        return ast.literal_eval(expression)

    def _concerns_node(self, call: ast.Call) -> bool:
        """Return whether a node is asked for something, or given to somebody, by a call."""
        words = {*_words(call.func)}
        if words & _SETTLED:
            return False
        given = [call.func, *call.args, *(word.value for word in call.keywords)]
        return any(_root(expression) in self._nodes for expression in given)


def _root(expression: ast.expr) -> str:
    """Return the name that an expression begins with: `sender` of `sender.client.send`."""
    while isinstance(expression, (ast.Attribute, ast.Call, ast.Subscript)):
        expression = expression.func if isinstance(expression, ast.Call) else expression.value
    return expression.id if isinstance(expression, ast.Name) else ""


def _words(expression: ast.expr) -> Iterator[str]:
    """Return the names in an expression: `get_logger` and `info` of `node.get_logger().info`."""
    for node in ast.walk(expression):
        if isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.Name):
            yield node.id


def quoted(call: ast.Call) -> str:
    """Return a call as text, its arguments left out where they are long."""
    text = ast.unparse(call)
    return text if len(text) <= _LONGEST else f"{ast.unparse(call.func)}(...)"
