"""What Textual works out for each app anew is worked out once for all the apps of a test run."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from textual import markup
from textual.content import Content
from textual.css import stylesheet
from textual.css.stylesheet import Stylesheet
from textual.css.tokenize import tokenize_values
from textual.dom import DOMNode

_Rules = Any


def share() -> None:
    """Parse style sheets and texts with marks once, and match rules to equal widgets once."""
    _share_parsing()
    _share_matching()


def _share_parsing() -> None:
    parse, known = Stylesheet._parse_rules, dict[object, Any]()

    def parse_once(self: Stylesheet, css: str, *options: Any, **named: Any) -> Any:
        key = (css, options, *sorted(named.items()), *sorted(self._variables.items()))
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


class _Matched:
    """The cache that Textual takes for one update, across updates and apps."""

    def __init__(self, known: dict[object, _Rules], sheet: Stylesheet) -> None:
        self._known = known
        self._rules = tuple(map(id, sheet.rules))  # shared by the apps: `parse_once` keeps them

    def get(self, key: tuple[Any, ...]) -> _Rules | None:
        return self._known.get(self._of_equals(key))

    def __setitem__(self, key: tuple[Any, ...], rules: _Rules) -> None:
        self._known[self._of_equals(key)] = rules

    def _of_equals(self, key: tuple[Any, ...]) -> object:
        """Return the key with all that selectors look at of a parent in its place."""
        parent, *itself = key
        path = () if parent is None else tuple(_seen(node) for node in parent.css_path_nodes)
        return self._rules, path, *itself


def _seen(node: DOMNode) -> object:
    return node._css_type_names, node._id, node.classes, node._pseudo_classes_cache_key


def _share_matching() -> None:
    apply, known = Stylesheet.apply, dict[object, _Rules]()

    def apply_once(
        self: Stylesheet, node: DOMNode, *, animate: bool = False, cache: object = None
    ) -> None:
        apply(self, node, animate=animate, cache=_Matched(known, self))  # type: ignore[arg-type]

    Stylesheet.apply = apply_once  # type: ignore[method-assign]
