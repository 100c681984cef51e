"""What Textual works out for each app anew is worked out once for all the apps of a test run."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any
from weakref import ref

from textual import markup
from textual.content import Content
from textual.css import stylesheet
from textual.css.stylesheet import Stylesheet
from textual.css.tokenize import tokenize_values
from textual.dom import DOMNode
from textual.message_pump import MessagePump

_Rules = Any
_made: list[ref[MessagePump]] = []  # Apps, screens, widgets and timers of the running test.
_MARK = "_shared_by_tests"  # The attribute of a style sheet with what identifies its parts.


def share() -> None:
    """Do once for the whole run what Textual does for each app.

    Style sheets and texts with marks are parsed, and rules are matched to equal widgets.
    """
    _share_parsing()
    _share_matching()
    _note_what_is_made()


def _note_what_is_made() -> None:
    create = MessagePump.__init__

    def create_and_note(self: MessagePump, *options: Any, **named: Any) -> None:
        create(self, *options, **named)
        _made.append(ref(self))

    MessagePump.__init__ = create_and_note  # type: ignore[method-assign]


def free_all() -> None:
    """Take apart what Textual has made: it is freed at once, without the garbage collector."""
    for made in _made:
        pump = made()
        if pump is not None:
            vars(pump).clear()
    _made.clear()


def _share_parsing() -> None:
    parse, known = Stylesheet._parse_rules, dict[object, Any]()

    def parse_once(self: Stylesheet, css: str, *options: Any, **named: Any) -> Any:
        key = (css, options, *sorted(named.items()), _number_of_variables(self))
        if key not in known:
            known[key] = parse(self, css, *options, **named)
        return known[key]

    Stylesheet._parse_rules = parse_once  # type: ignore[method-assign]

    tokenized = lru_cache(lambda values: tokenize_values(dict(values)))
    by_items = lambda values: tokenized(tuple(values.items()))  # noqa: E731
    vars(stylesheet)["tokenize_values"] = by_items
    to_content = markup.to_content
    marked = lru_cache(10_000)(to_content)

    def mark_once(text: str, style: Any = "", template_variables: Any = None) -> Content:
        if template_variables or not isinstance(style, str):
            return to_content(text, style, template_variables)
        return marked(text, style)

    vars(markup)["to_content"] = mark_once


_numbers: dict[object, int] = {}  # Of equal parts of style sheets.


def _number_of(sheet: Stylesheet, name: str, part: Any, identify: Callable[[Any], object]) -> int:
    """Return the same number for equal parts; the part is looked at when it is another object."""
    marks = vars(sheet).setdefault(_MARK, {})
    if name not in marks or marks[name][0] is not part:
        marks[name] = part, _numbers.setdefault((name, identify(part)), len(_numbers))
    number: int = marks[name][1]
    return number


def _number_of_variables(sheet: Stylesheet) -> int:
    identify = lambda values: tuple(sorted(values.items()))  # noqa: E731
    return _number_of(sheet, "variables", sheet._variables, identify)


def _number_of_rules(sheet: Stylesheet) -> int:
    # The rules are objects that all apps share: `parse_once` keeps them.
    return _number_of(sheet, "rules", sheet.rules, lambda rules: tuple(map(id, rules)))


class _Matched:
    """In place of the cache that Textual makes for one update: notes the rules of one widget."""

    def __init__(self) -> None:
        self.rules: _Rules = None

    def get(self, key: object) -> None:
        return None

    def __setitem__(self, key: object, rules: _Rules) -> None:
        self.rules = rules


_OF_RULES = ("_has_hover_style", "_has_focus_within", "_has_order_style", "_has_odd_or_even")


def _seen(node: DOMNode) -> object:
    """Return all that selectors look at in a widget and its parents."""
    return tuple(
        (one._css_type_names, one._id, one.classes, one._pseudo_classes_cache_key)
        for one in node.css_path_nodes
    )


def _share_matching() -> None:
    apply, known = Stylesheet.apply, dict[object, tuple[_Rules, tuple[bool, ...]]]()

    def apply_once(
        self: Stylesheet, node: DOMNode, *, animate: bool = False, cache: object = None
    ) -> None:
        key = _number_of_rules(self), node._css_type_name, _seen(node)
        if key in known:
            rules, flags = known[key]
            vars(node).update(zip(_OF_RULES, flags, strict=True))
            self.replace_rules(node, rules, animate=animate)
            self._process_component_classes(node)
            return
        matched = _Matched()
        apply(self, node, animate=animate, cache=matched)  # type: ignore[arg-type]
        if matched.rules is not None:  # Else they depend on other widgets, too.
            known[key] = matched.rules, tuple(vars(node)[name] for name in _OF_RULES)

    Stylesheet.apply = apply_once  # type: ignore[method-assign]
