"""Values as YAML that means the same to everybody: to the console, to `ros2` and to a shell's user.

Texts are quoted that YAML 1.1, which `ros2` reads, or 1.2, which the console reads, would take for
something else.
"""

from __future__ import annotations

import base64
import re
from typing import Any

import yaml

_NAME = re.compile(r"[A-Za-z_][\w/]*", re.ASCII)


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.Node:
    plain = _NAME.fullmatch(text) and yaml.safe_load(text) == text
    plain = plain and text.lower() != "none"  # which in a robot file means that there is none
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=None if plain else '"')


def _bytes(dumper: yaml.SafeDumper, data: bytes) -> yaml.Node:
    encoded = base64.b64encode(data).decode()
    return dumper.represent_scalar("tag:yaml.org,2002:binary", encoded, style='"')


_Dumper.add_representer(str, _text)
_Dumper.add_representer(bytes, _bytes)


def flow(value: Any) -> str:
    """In one line: `{pose: {x: 1.0}, labels: [a, "12"]}`."""
    return _dumped(value, True).partition("\n")[0]


def block(value: Any) -> str:
    """In lines, nested as it is."""
    return _dumped(value, False)


def _dumped(value: Any, flow_style: bool) -> str:
    text: str = yaml.dump(
        value,
        Dumper=_Dumper,
        default_flow_style=flow_style,
        sort_keys=False,
        allow_unicode=True,
        width=10**9,
    )
    return text
