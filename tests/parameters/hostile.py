"""Files that nobody should have to read, and places that nobody should write to."""

from __future__ import annotations

import os
from pathlib import Path

HEAD = "/**:\n  ros__parameters:\n    name: "


def readable(folder: Path) -> dict[str, str]:
    """Files by name with what is said of each."""
    texts = {
        "aliases": (f"{HEAD}&a [*a]\n", ":3: aliases (*a) are not read"),
        "bomb": (
            "a: &a [x, x]\n" + "".join(f"b{n}: &b{n} [*a, *a]\n" for n in range(9)),
            ":2: aliases (*a) are not read",
        ),
        "deep": (f"{HEAD}{'[' * 3000}{']' * 3000}\n", ":3: nested more than 20 deep"),
        "digits": (f"{HEAD}{'9' * 5000}\n", ":3: a number of 5000 digits"),
        "large": ("#" * 10_000_000, ": larger than 1 MB"),
    }
    for name, (text, _) in texts.items():
        (folder / name).write_text(text)
    return {str(folder / name): said for name, (_, said) in texts.items()}


def places(folder: Path) -> dict[str, str]:
    """Paths by what is typed, with what is said of each, for reading and for writing."""
    os.mkfifo(folder / "fifo")
    (folder / "loop").symlink_to(folder / "loop")
    (folder / "dangling").symlink_to(folder / "nowhere")
    return {
        "/": "/: not a regular file",
        ".": ".: not a regular file",
        "x" * 300: "File name too long",
        str(folder / "fifo"): "fifo: not a regular file",
        "/dev/null": "/dev/null: not a regular file",
        str(folder / "loop"): "Too many levels of symbolic links",
    }
