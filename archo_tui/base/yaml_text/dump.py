"""A YAML writer whose text means the same to the console, to `ros2` and to a shell's user.

A text is quoted if YAML 1.1, which `ros2` reads, or YAML 1.2, which the console reads, would take
it for something else.
"""

from __future__ import annotations

import base64
import re
from typing import Any

import yaml

# PyYAML escapes emoji in quotes, though not outside of them. All backslashes are within quotes.
_ESCAPE = re.compile(r"\\\\|\\U([0-9A-F]{8})")
_NAME = re.compile(r"[A-Za-z_][\w/]*(\.[\w/]+)*", re.ASCII)


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.Node:
    plain = _NAME.fullmatch(text) and yaml.safe_load(text) == text
    plain = plain and text.lower() != "none"  # Unquoted, robot files read it as "left out".
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=None if plain else '"')


def _represent_bytes(dumper: yaml.SafeDumper, data: bytes) -> yaml.Node:
    encoded = base64.b64encode(data).decode()
    return dumper.represent_scalar("tag:yaml.org,2002:binary", encoded, style='"')


_Dumper.add_representer(str, _represent_text)
_Dumper.add_representer(bytes, _represent_bytes)


def flow(value: Any) -> str:
    """Return a value as YAML on one line: `{pose: {x: 1.0}, labels: [a, "12"]}`."""
    return _dump(value, True).partition("\n")[0]


def block(value: Any) -> str:
    """Return a value as YAML with a line for each entry; it ends in a newline."""
    return _dump(value, False)


def mixed(value: Any) -> str:
    """Return a value as YAML in blocks, with the innermost lists and mappings on a line each."""
    return _dump(value, None)


def _dump(value: Any, flow_style: bool | None) -> str:
    text: str = yaml.dump(
        value,
        Dumper=_Dumper,
        default_flow_style=flow_style,
        sort_keys=False,
        allow_unicode=True,
        width=10**9,
    )
    return _ESCAPE.sub(_unescaped, text)


def _unescaped(found: re.Match[str]) -> str:
    char = chr(int(found[1], 16)) if found[1] else ""
    return char if char.isprintable() and char else found[0]
