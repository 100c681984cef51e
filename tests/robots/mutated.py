"""Robot files with something wrong in them: bytes, lines or values changed at random."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

# what a value, or a piece of a line, is replaced by
ODD = (
    *("none", "~", '"none"', "''", "yes", "word", "a b", "stop", "quit", "é", "'\\xe9'"),
    *("-1", "0", "1e999", ".nan", "-.inf", "1:30", "0x1F", "010", "9" * 5000, "2020-99-99"),
    *("[]", "{}", "[a, [b]]", "{a: 1}", "{a: 1, a: 2}", "[[[[", "{{{{", "- a\n  - b"),
    *("!!int x", '!!int ""', "!!bool q", "!!float z", "!!null x", "!!timestamp bad"),
    *("!!binary x", "!!set {a}", "!!omap [a: 1]", "!!pairs [a]", "!!map x", "!!seq x"),
    *("!!python/object:os.system x", "&a [*a]", "{<<: {a: 1}}", "{? [a] : b}", "|", ">"),
    *("%YAML 9.9", f"%YAML {'9' * 5000}.1", "---", "...", "# x", "\\xff", "\t", "\r"),
    *('"\\x1b[2J\\n"', '"\\uD800"', '"\\UFFFFFFFF"', "\x1b", "\0", "\x85", "\u2028", "\u202e"),
)


def mutated(files: list[Path], number: int, seed: int) -> Iterator[bytes]:
    """So many texts made from these files."""
    chance = random.Random(seed)
    known = []
    for file in files:
        text = file.read_text(encoding="utf-8")
        known.append((text, sorted(_places(yaml.compose(text, Loader=yaml.SafeLoader)))))
    for _ in range(number):
        text, places = chance.choice(known)
        last = len(text)
        for start, end in reversed(chance.sample(places, chance.choice((0, 1, 1, 1, 2, 3)))):
            if end <= last:  # not in what was replaced already
                text, last = text[:start] + chance.choice(ODD) + text[end:], start
        data = text.encode()
        yield data if chance.random() < 0.7 else chance.choice((_line, _bytes))(data, chance)


def _places(node: Any) -> Iterator[tuple[int, int]]:
    """Where names and values stand."""
    yield node.start_mark.index, node.end_mark.index
    if isinstance(node, yaml.ScalarNode):
        return
    for item in node.value:
        for part in item if isinstance(item, tuple) else (item,):
            yield from _places(part)


def _line(data: bytes, chance: random.Random) -> bytes:
    """A line less, or twice."""
    lines = data.split(b"\n")
    place = chance.randrange(len(lines))
    lines[place : place + 1] = chance.choice(([], [lines[place]] * 2))
    return b"\n".join(lines)


def _bytes(data: bytes, chance: random.Random) -> bytes:
    """A few bytes less, or another one."""
    place = chance.randrange(len(data) + 1)
    new = chance.choice((b"", bytes([chance.randrange(256)])))
    return data[:place] + new + data[place + chance.randrange(12) :]
