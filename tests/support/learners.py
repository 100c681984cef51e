"""What learners write: `share/learners.txt`, each text whole or by its differences from another."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

_FILE = Path(__file__).parent.parent / "share" / "learners.txt"


class Learner(NamedTuple):
    """A file of a learner, and the lines that say what is expected of it."""

    expected: list[str]
    text: str


def _differing(text: str, lines: list[str]) -> str:
    """The text with each run of `-` lines, which it has once, made the `+` lines behind it."""
    for change in "\n".join(lines).split("\n@\n"):
        old, new = (
            "".join(f"{line[1:]}\n" for line in change.splitlines() if line[0] == sign)
            for sign in "-+"
        )
        found = re.findall(rf"^{re.escape(old)}", text, re.MULTILINE)
        assert len(found) == 1, change
        text = re.sub(rf"^{re.escape(old)}", lambda _, new=new: new, text, flags=re.MULTILINE)  # type: ignore[misc]
    return text


def _read() -> dict[str, Learner]:
    read: dict[str, Learner] = {}
    for part in _FILE.read_text(encoding="utf-8").split("=== ")[1:]:
        heading, _what, *lines = part.splitlines()
        name, _, base = heading.partition(" = ")
        expected = [line for line in lines if line.startswith("# ")]
        lines = [line for line in lines if line and not line.startswith("# ")]
        if base:
            text = _differing(read[base].text, lines)
        else:
            text = "".join(f"{line[1:]}\n" for line in lines)
        read[name] = Learner(expected, text)
    return read


LEARNERS = _read()


def write(name: str, folder: Path) -> Path:
    """Return the learner's file, written into a folder."""
    file = folder / f"{name}.py"
    file.write_text(LEARNERS[name].text, encoding="utf-8")
    return file
