"""The nodes that `main()` of a node file makes and its other calls, read from the syntax tree.

`main()` itself is never run.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import rclpy
from rclpy.node import Node

_MAX_QUOTED = 60  # Characters of a call that is quoted whole.
# Calls that the host makes in another way, or that change nothing in what a node does.
_NOT_MISSED = {
    *("init", "ok", "shutdown", "try_shutdown", "destroy_node", "add_node", "remove_node"),
    *("spin", "spin_once", "spin_until_future_complete", "get_logger", "get_name", "print"),
    *("append", "extend", "list", "isinstance"),
}


class ComputedError(Exception):
    """The error for an argument of a node whose value only running `main()` could tell.

    Attributes:
        line: The line of the call that makes the node.
    """

    def __init__(self, call: ast.Call) -> None:
        """Create the error for the call that makes the node."""
        super().__init__(quoted(call))
        self.line = call.lineno


class NodeCall(NamedTuple):
    """A call in `main()` that makes a node.

    Attributes:
        node_class: The class of the node.
        args: The arguments by position.
        keywords: The arguments by name, but for `context`.
        line: The line of the call; 0 for a node that `main()` does not make.
        text: The call as it is quoted; "" for a node that `main()` does not make.
    """

    node_class: type[Node]
    args: tuple[Any, ...]
    keywords: dict[str, Any]
    line: int
    text: str


class SkippedCall(NamedTuple):
    """A call in `main()` that concerns a node and is not made when the node is hosted.

    Attributes:
        line: Its line.
        function: The function that makes it; "" below `if __name__ == "__main__"`.
        text: The call as it is quoted.
    """

    line: int
    function: str
    text: str


class MainFunction(ast.NodeVisitor):
    """The calls below the module's `if`s, or in `main()` if these make no node, in their order.

    Calls in the file's functions that these call are among them.

    Attributes:
        made: The calls that make nodes; of equal ones the first.
        not_run: The calls that concern a node and are not made here, up to the first spin.
    """

    def __init__(self, tree: ast.Module, names: Mapping[str, Any]) -> None:
        """Collect the calls below the module's `if`s, and those of `main()` if these make no node.

        Args:
            tree: The file's syntax tree.
            names: The content of the file's module, by name.

        Raises:
            ComputedError: An argument of a node has a value that only `main()` could tell.
        """
        self.made: list[NodeCall] = []
        self.not_run: list[SkippedCall] = []
        self._names = names
        self._functions = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
        self._within: list[str] = []  # The names of the functions that are being followed.
        self._nodes: set[str] = set()  # The local names of nodes.
        self._values: dict[str, Any] = {}  # Local names whose values stand in the file.
        self._spins = False  # True behind a spin: later calls are made at the end, if ever.
        self._follow_all(tree)

    def _follow_all(self, tree: ast.Module) -> None:
        ifs = [node for node in tree.body if isinstance(node, ast.If)]
        for statement in ifs:
            self.visit(statement)
        if not self.made and "main" in self._functions:
            self._spins = False
            self._follow(self._functions["main"], ())

    def _follow(self, function: ast.FunctionDef, given: Sequence[ast.expr]) -> None:
        """Collect the calls of a function of the file, called with these arguments by position."""
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
        """Skip a definition: the body of a function is read where it is called."""

    visit_AsyncFunctionDef = visit_ClassDef = visit_Lambda = visit_FunctionDef  # type: ignore

    def visit_Try(self, node: ast.Try) -> None:
        """Read body and `else`; skip `except` and `finally`, run after a failure or at the end."""
        for statement in [*node.body, *node.orelse]:
            self.visit(statement)

    def visit_Assign(self, node: ast.Assign) -> None:
        """Read the calls of the assigned value; remember if its name is now a node or a value."""
        count = len(self.made)
        self.visit(node.value)
        for target in node.targets:
            if isinstance(target, ast.Name):
                self._bind(target.id, node.value, len(self.made) > count)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Treat an annotated assignment as a plain one; skip an annotation without a value."""
        if node.value is not None:
            self.visit_Assign(ast.Assign([node.target], node.value))

    def visit_With(self, node: ast.With) -> None:
        """Treat `with Talker() as talker` as an assignment, then read the body."""
        for item in node.items:
            targets = [] if item.optional_vars is None else [item.optional_vars]
            self.visit_Assign(ast.Assign(targets, item.context_expr))
        for statement in node.body:
            self.visit(statement)

    def visit_Call(self, node: ast.Call) -> None:
        """Add a call that makes a node to `made`, and another one about a node to `not_run`.

        A call of a function of the file leads to the calls in its body instead, unless it is
        recursive. The arguments of a call are read first. After a call of `spin`, nothing is added
        to `not_run`.

        Raises:
            ComputedError: The call makes a node, and only `main()` could tell a value of it.
        """
        self.generic_visit(node)
        function = node.func
        own = self._functions.get(function.id) if isinstance(function, ast.Name) else None
        node_class = self._node_class(function)
        if own is not None:
            if own.name not in self._within:
                self._follow(own, node.args)
        elif node_class is not None:
            self._make(node_class, node)
        elif not self._spins and self._concerns_node(node):
            within = self._within[-1] if self._within else ""
            self.not_run.append(SkippedCall(node.lineno, within, quoted(node)))
        if isinstance(function, (ast.Attribute, ast.Name)):
            name = function.attr if isinstance(function, ast.Attribute) else function.id
            self._spins |= name == "spin"

    def _node_class(self, function: ast.expr) -> type[Node] | None:
        """Return the class of the node that calling `function` makes; None if it makes none."""
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

    def _make(self, node_class: type[Node], call: ast.Call) -> None:
        given = {word.arg: word.value for word in call.keywords if word.arg != "context"}
        try:
            args = tuple(self._value(argument, self._values) for argument in call.args)
            keywords = {
                name or "": self._value(value, self._values) for name, value in given.items()
            }
        except ValueError:
            raise ComputedError(call) from None
        made = NodeCall(node_class, args, keywords, call.lineno, quoted(call))
        # An `if` and its `else` may both make the same node.
        if not any(made[:3] == other[:3] for other in self.made):
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
        """Return the value of a literal, or of a name of `values` or of the file's module.

        Args:
            expression: The expression.
            values: The local names whose values are known.

        Raises:
            ValueError: The value does not stand in the file.
        """
        if isinstance(expression, ast.Name):
            for known in (values, self._names):
                if expression.id in known:
                    return known[expression.id]
        return ast.literal_eval(expression)

    def _concerns_node(self, call: ast.Call) -> bool:
        """Return True if a call is of a method of a node, or has a node as an argument.

        Calls that the host replaces or that change nothing, as `spin` and `get_logger`, do not
        count.
        """
        words = {*_words(call.func)}
        if words & _NOT_MISSED:
            return False
        given = [call.func, *call.args, *(word.value for word in call.keywords)]
        return any(_root(expression) in self._nodes for expression in given)


def _root(expression: ast.expr) -> str:
    """Return the name that an expression begins with: `sender` of `sender.client.send`; else ""."""
    while isinstance(expression, (ast.Attribute, ast.Call, ast.Subscript)):
        expression = expression.func if isinstance(expression, ast.Call) else expression.value
    return expression.id if isinstance(expression, ast.Name) else ""


def _words(expression: ast.expr) -> Iterator[str]:
    """Yield the names in an expression: `get_logger` and `info` of `node.get_logger().info`."""
    for node in ast.walk(expression):
        if isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.Name):
            yield node.id


def quoted(call: ast.Call) -> str:
    """Return a call as text; as `name(...)` if that is longer than 60 characters."""
    text = ast.unparse(call)
    return text if len(text) <= _MAX_QUOTED else f"{ast.unparse(call.func)}(...)"
