"""What a typed text means for a field of a message, and what is said when it means nothing."""

from __future__ import annotations

from typing import Any

import pytest

from archo_tui.robot.forms import parse
from archo_tui.robot.state import Leaf
from archo_tui.robots.model import Input


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        ("int32", " +12 ", 12),
        ("int32", f"{'0' * 40}12", 12),
        ("double", ".5", 0.5),
        ("double", "-5.", -5.0),
        ("float", "1e3", 1000.0),
        ("sequence<int32>", "[1, -2]", [1, -2]),
        ("sequence<double, 5>", "[1, .5]", [1.0, 0.5]),
        ("double[2]", "[1e3, +2]", [1000.0, 2.0]),
        ("sequence<string>", "[a, 'b c']", ["a", "b c"]),
    ],
)
def test_the_type_of_the_field_decides(kind: str, text: str, value: Any) -> None:
    assert parse(Leaf("x", kind, None), Input(), text) == value


@pytest.mark.parametrize("text", ["1_2", "０５", "٣", "1_0.5", "infinity", "0x10", "1 2", "--1"])
@pytest.mark.parametrize(
    ("kind", "what"),
    [("int32", "a whole number"), ("double", "a number"), ("sequence<double>", "a list")],
)
def test_what_only_python_or_yaml_takes_is_no_number(kind: str, what: str, text: str) -> None:
    typed = f"[{text}]" if what == "a list" else text
    with pytest.raises(ValueError) as caught:
        parse(Leaf("x", kind, None), Input(label="Way"), typed)
    assert str(caught.value) == f"Way: not {what}: {typed}"
