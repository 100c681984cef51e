"""A robot as the text of its file: what differs from the defaults, in the model's order."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import yaml

from archo_tui.robots import typed_yaml
from archo_tui.robots.model import Robot

_WORD = re.compile(r"/?[^\W\d_][\w/. -]*")
_HEAD = '# Written by archo-tui. What the words mean: README, "Your own robot".\n'


def dump(robot: Robot) -> str:
    """The text that `load` reads back as the same robot."""
    said = {"version": robot.version, **_plain(robot)}
    return _HEAD + yaml.dump(said, Dumper=_Dumper, sort_keys=False, allow_unicode=True)


class _Dumper(yaml.SafeDumper):
    """Quotes whatever could be read as something else than a text, `none` too."""


def _quoted(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    is_word = _WORD.fullmatch(text) and text.lower() not in typed_yaml.NONE
    style = None if is_word else "'"
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _quoted)


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        found = {}
        for item in fields(value):
            given = getattr(value, item.name)
            default = item.default
            if item.default_factory is not MISSING:
                default = item.default_factory()
            if item.name != "where" and given != default:
                found[item.name] = _plain(given)
        return next(iter(found.values())) if list(found) == ["field"] else found
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
