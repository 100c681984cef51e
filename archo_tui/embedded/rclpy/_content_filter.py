"""DDS filter expressions, as Fast DDS reads them: `level < %0 AND name LIKE 'arm%'`.

Comparisons of fields with literals, parameters and each other, BETWEEN, LIKE, MATCH, NOT and
brackets. AND and OR have the same rank and are taken from the left.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import Any, NamedTuple

_TOKEN = re.compile(
    r"\s*(?:(?P<string>['`][^']*')"
    r"|(?P<number>[+-]?(?:0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))"
    r"|(?P<parameter>%\d+)"
    r"|(?P<name>[A-Za-z_][\w.\[\]]*)"
    r"|(?P<sign><>|!=|>=|<=|[=<>()]))"
)
_STEP = re.compile(r"(\w+)(?:\[(\d+)\])?")
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_WILD = str.maketrans({"%": ".*", "*": ".*", "_": ".", "?": "."})  # what else is in it is a regex

Test = Callable[[Any], bool]  # of a message


class _Operand(NamedTuple):
    """A value of a message, or one that is always the same."""

    get: Callable[[Any], Any]
    is_text: bool
    is_field: bool


def compile_filter(expression: str, parameters: list[str], msg_type: Any) -> Test:
    """What tells whether a message passes. Raises ValueError for what is no such expression."""
    parser = _Parser(expression, parameters, msg_type)
    test = parser.alternatives()
    if parser.peek():
        raise ValueError(f"{parser.peek()!r} is too much")

    def passes(message: Any) -> bool:
        try:
            return test(message)
        except IndexError:  # an array that is too short
            return False

    return passes


class _Parser:
    """Reads an expression from the left."""

    def __init__(self, expression: str, parameters: list[str], msg_type: Any) -> None:
        self._tokens = _tokens(expression)
        self._parameters, self._type = parameters, msg_type

    def peek(self) -> str:
        """The next token, words in capitals; empty at the end."""
        kind, text = self._tokens[0] if self._tokens else ("", "")
        return text.upper() if kind == "name" else text

    def _take(self, *wanted: str) -> str:
        found = self.peek()
        if wanted and found not in wanted:
            raise ValueError(f"{' or '.join(wanted)} is missing before {found!r}")
        if self._tokens:
            self._tokens.pop(0)
        return found

    def alternatives(self) -> Test:
        """One condition, or several."""
        test = self._condition()
        while self.peek() in ("AND", "OR"):
            join = all if self._take() == "AND" else any
            both = test, self._condition()
            test = _joined(join, both)
        return test

    def _condition(self) -> Test:
        if self.peek() == "NOT":
            self._take()
            inner = self._condition()
            return lambda message: not inner(message)
        if self.peek() == "(":
            self._take()
            test = self.alternatives()
            self._take(")")
            return test
        return self._comparison()

    def _comparison(self) -> Test:
        left = self._operand()
        negated = self.peek() == "NOT"
        word = self._take("NOT", "BETWEEN", "LIKE", "MATCH", *_COMPARE)
        if negated or word == "BETWEEN":
            if negated:
                self._take("BETWEEN")
            low = self._operand()
            self._take("AND")
            high = self._operand()
            _check(left.is_field and left.is_text == low.is_text == high.is_text)
            return lambda m: (low.get(m) <= left.get(m) <= high.get(m)) != negated
        right = self._operand()
        _check((left.is_field or right.is_field) and left.is_text == right.is_text)
        if word in _COMPARE:
            compare = _COMPARE[word]
            return lambda m: compare(left.get(m), right.get(m))
        _check(left.is_field and left.is_text and not right.is_field)
        text = right.get(None)
        pattern = re.compile(text.translate(_WILD) if word == "LIKE" else text, re.DOTALL)
        return lambda m: pattern.fullmatch(left.get(m)) is not None

    def _operand(self) -> _Operand:
        kind, text = self._tokens.pop(0) if self._tokens else ("", "")
        if kind == "parameter":
            number = int(text[1:])
            _check(number < len(self._parameters))
            (kind, text), *others = _tokens(self._parameters[number]) or [("", "")]
            _check(kind != "parameter" and not others and not self._is_field(kind, text))
        if self._is_field(kind, text):
            return self._field(text)
        if kind == "name":
            truth = text.upper() == "TRUE"
            return _Operand(lambda _: truth, False, False)
        if kind == "string":
            return _Operand(lambda _: text[1:-1], True, False)
        _check(kind == "number")
        value = _number(text)
        return _Operand(lambda _: value, False, False)

    def _is_field(self, kind: str, text: str) -> bool:
        return kind == "name" and text.upper() not in ("TRUE", "FALSE")

    def _field(self, path: str) -> _Operand:
        """A field by its path: `stamp.sec`, `data[2]`. What is no single value is no operand."""
        steps: list[tuple[str, int | None]] = []
        kind, field = self._type, None
        for step in path.split("."):
            found = _STEP.fullmatch(step)
            _check(found is not None and kind is not None)
            assert found is not None
            name, index = found[1], None if found[2] is None else int(found[2])
            fields = {slot[1:]: (field, nested) for slot, field, nested in kind.__layout__}
            _check(name in fields)
            field, kind = fields[name]
            _check(field.is_array == (index is not None))
            steps.append((name, index))
        _check(kind is None and field is not None)

        def get(message: Any) -> Any:
            for name, index in steps:
                message = getattr(message, name)
                message = message if index is None else message[index]
            return message[0] if isinstance(message, bytes) else message

        return _Operand(get, field is not None and field.base in ("string", "wstring"), True)


def _tokens(text: str) -> list[tuple[str, str]]:
    """Kind and text of each."""
    tokens, place, text = [], 0, text.rstrip()
    while place < len(text):
        found = _TOKEN.match(text, place)
        if found is None or found.lastgroup is None:
            raise ValueError(f"{text[place:]!r} cannot be read")
        tokens.append((found.lastgroup, found[found.lastgroup]))
        place = found.end()
    return tokens


def _joined(join: Callable[[Any], bool], both: tuple[Test, Test]) -> Test:
    return lambda message: join(test(message) for test in both)


def _number(text: str) -> float:
    try:
        return int(text, 0)
    except ValueError:
        return float(text)


def _check(holds: bool) -> None:
    if not holds:
        raise ValueError("these cannot be compared")
