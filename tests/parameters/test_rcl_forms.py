"""Parameter files mean what rcl makes of them.

The answers are those of Jazzy (rclpy 7.1), taken down once: each file was given to `rclpy.init` by
`--params-file`, and the overrides of six nodes were read.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from archo_tui.base.yaml_text.bounded_yaml import YamlError
from archo_tui.ros.embedded.parameter_files import matches, read

SHARE = Path(__file__).parent.parent / "share"
ANSWERS = json.loads((SHARE / "parameter_files_jazzy.json").read_text())
# What rcl reads as something else without a word, by a fault of its own, is refused here.
STRICTER = {
    *("value [[1]]", "value [[]]", "value [1, [2]]", "value [{a: 1}]", "block list of maps"),
    *("value {}", "parameter twice, other type", "scalar"),
}
# Numbers that nobody writes: too small for a double, or hexadecimal and no integer of 64 bits.
OTHER = {"value 1e-400", "value 0x1.8p1", "value 0x1p3", "value 0xffffffffffffffff"}
NODES = ("/n", "/m", "/a/n", "/a/b/n", "/n/m", "/motor")


def kind_of(value: Any) -> str:
    if isinstance(value, list):
        return f"{type(value[0]).__name__}[]" if value else "none"
    return type(value).__name__


def meaning(file: Path) -> Any:
    """What each node gets of a file, or that it is refused."""
    try:
        overrides = read(file)
    except YamlError as error:
        return "refused" if re.match(r".*file\.yaml(:\d+)?: ", str(error)) else str(error)
    found: dict[str, Any] = {}
    for node in NODES:
        for override in overrides:
            if matches(override.pattern, node):
                value = None if override.value == [] else override.value
                kind = kind_of(override.value)
                found.setdefault(node, {})[override.name] = [kind, repr(value)]
    return found


def test_a_file_means_what_rcl_makes_of_it(tmp_path: Path) -> None:
    file, wrong = tmp_path / "file.yaml", list[str]()
    for answer in ANSWERS:
        if answer["form"] in OTHER:
            continue
        file.write_bytes(answer["text"].encode())
        is_refused = "refused" in answer or answer["form"] in STRICTER
        if meaning(file) != ("refused" if is_refused else answer["nodes"]):
            wrong.append(answer["form"])
    assert wrong == []
